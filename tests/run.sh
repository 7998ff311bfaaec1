#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs all tests; installs what is missing first (Debian, Ubuntu).   sh tests/run.sh
#   CXX              the compiler, g++ if not given
#   CXXFLAGS         flags behind the usual ones, such as -fsanitize=address,undefined
#   RUNNER           what runs the test program, such as qemu-s390x; nothing if not given
#   TEST_ARGUMENTS   what the test program is given, such as --test-case=G2*
#   BUILD            where to build; a temporary directory if not given
#   JOBS             compilers at a time, 2 if not given
#   SKIP_OWN_CHECKS  1: only the test program, not the wrong programs and the tools' own checks
set -u
cd "$(dirname "$0")/.." || exit 1

install() {
    echo "run.sh: installing $* with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends "$@" >/dev/null || {
        echo "run.sh: $* could not be installed"
        exit 1
    }
}

CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
if ! echo '#include <doctest/doctest.h>' | $CXX -x c++ -std=c++20 -fsyntax-only - 2>/dev/null; then
    install doctest-dev
fi

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
    trap 'rm -rf "$build"' EXIT
fi

usual="-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
flags="$usual -D_GLIBCXX_ASSERTIONS -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I. ${CXXFLAGS:-}"
case $flags in # doctest ends a failed REQUIRE by an exception, where there are any
*-fno-exceptions*) flags="$flags -DDOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS" ;;
esac
failed=0
summary=""

# part NAME COMMAND...: runs a part and keeps its result for the last line.
part() {
    name=$1
    shift
    if "$@"; then
        summary="$summary$name passed, "
    else
        summary="$summary$name FAILED, "
        failed=1
    fi
}

# together NAME SCRIPT ARGUMENT...: runs a script beside others, since they mostly wait; `all_together` ends them.
# What they check is in real time: tests/support/undisturbed.cpp.
begun=""
together() {
    name=$1
    shift
    log=$(mktemp -p "$build")
    echo "$name" >"$log.name"
    "$build/undisturbed" sh "$@" >"$log" 2>&1 &
    begun="$begun $log:$!"
}
ended() { # LOG PID
    wait "$2"
    status=$?
    cat "$1"
    return $status
}
all_together() {
    for one in $begun; do
        part "$(cat "${one%:*}.name")" ended "${one%:*}" "${one#*:}"
    done
}

# Names of sources are plain, so that word splitting is harmless.
objects=""
sources=$(ls tests/run/*.cpp tests/static/*.cpp 2>/dev/null)
for source in $sources; do
    objects="$objects $build/$(echo "${source%.cpp}" | tr / _).o"
done

# The compiler takes most of the time, so what runs but a moment is not optimised; in an emulator all is.
busy=$(grep -v '^#' tests/run/busy.txt)
quickly=-O0
[ -z "${RUNNER:-}" ] || quickly=-O1

compile_all() {
    rm -f $objects
    echo "run.sh: building $(echo "$sources" | wc -l) sources with $CXX"
    echo "$sources" | xargs -P "${JOBS:-2}" -I{} sh -c '
        source=$1; build=$2; quickly=$3; busy=$4; shift 4
        case " $busy " in *" $(basename "$source" .cpp) "*) level=-O1 ;; *) level=$quickly ;; esac
        "$@" $level -c "$source" -o "$build/$(echo "${source%.cpp}" | tr / _).o" || exit 1' \
        compile {} "$build" "$quickly" "$(echo $busy)" $CXX $flags || return 1
    $CXX $flags $objects -o "$build/tests"
}

run_all() { compile_all && ${RUNNER:-} "$build/tests" ${TEST_ARGUMENTS:-}; }

# The tool's sources are many, and one command would compile them one after the other.
build_tools() {
    programs=$(ls examples/servobus/*.cpp examples/wheels/main.cpp examples/stepper/main.cpp examples/servo/main.cpp)
    mkdir -p "$build/examples"
    echo "$programs" | xargs -P "${JOBS:-2}" -I{} sh -c '
        source=$1; build=$2; shift 2
        "$@" -c "$source" -o "$build/$(echo "${source%.cpp}" | tr / _).o" || exit 255' \
        compile {} "$build/examples" $CXX -std=c++20 -O1 -Iinclude ${CXXFLAGS:-} &&
        $CXX ${CXXFLAGS:-} "$build"/examples/examples_servobus_*.o -o "$build/servobus" || return 1
    for program in wheels stepper servo; do
        $CXX ${CXXFLAGS:-} "$build/examples/examples_${program}_main.o" -o "$build/$program" || return 1
    done
    $CXX -std=c++20 -O1 tests/support/undisturbed.cpp -o "$build/undisturbed" && ! "$build/undisturbed" false
}

part "tests" run_all
if [ "${SKIP_OWN_CHECKS:-0}" != 1 ]; then
    part "wrong programs" sh tests/fail/run.sh "$CXX"
    part "page of compile errors" sh tests/fail/page.sh --check
    part "tools' build" build_tools
    for file in tests/tool/*.sh; do
        tool_part=$(basename "$file" .sh)
        together "tool's $tool_part" tests/tool.sh "$build/servobus" "$tool_part"
    done
    for program in wheels stepper servo; do
        together "$program program" "tests/$program.sh" "$build/servobus" "$build/$program"
    done
    all_together
fi

if [ "$failed" = 0 ]; then
    echo "run.sh: all passed ($CXX): ${summary%, }"
else
    echo "run.sh: FAILED ($CXX): ${summary%, }"
fi
exit "$failed"
