#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs all tests; installs missing packages first (Debian, Ubuntu).   sh tests/run.sh
#   CXX              the compiler, g++ if not given
#   CXXFLAGS         flags after the usual ones, such as -fsanitize=address,undefined
#   RUNNER           a command that runs the test program, such as qemu-s390x; none if not given
#   TEST_ARGUMENTS   arguments of the test program, such as --test-case=G2*
#   BUILD            where to build; a temporary directory if not given
#   JOBS             compilers at a time, 2 if not given
#   QUICK            1: without the sources in tests/run/busy.txt, which an emulator runs for minutes
#   SKIP_OWN_CHECKS  1: only the test program, without the programs that must not compile and the tests of the tools
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
if ! echo '#include <doctest/doctest.h>' | $CXX -x c++ -std=c++20 -fsyntax-only - 2>/dev/null; then
    must_install doctest-dev
fi
[ "${SKIP_OWN_CHECKS:-0}" = 1 ] || command -v python3 >/dev/null 2>&1 || must_install python3

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
    trap 'rm -rf "$build"' EXIT
fi

usual="-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
flags="$usual -D_GLIBCXX_ASSERTIONS -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I. ${CXXFLAGS:-}"
case $flags in # doctest ends a failed REQUIRE by an exception if exceptions are enabled
*-fno-exceptions*) flags="$flags -DDOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS" ;;
esac
failed=0
summary=""
now() { date +%s; }

# part NAME COMMAND...: runs a part, prints its time, and keeps its result for the last line.
part() {
    name=$1
    shift
    start=$(now)
    if "$@"; then result=passed; else result=FAILED failed=1; fi
    echo "run.sh: $name $result, $(($(now) - start)) s"
    summary="$summary$name $result, "
}

# together NAME SCRIPT ARGUMENT...: runs a script in the background, since it mostly waits; `all_together` waits for the
# scripts. They check real time: so compilers run at a lower priority (`politely`), and a script runs again if the
# machine was suspended meanwhile (tests/support/undisturbed.cpp).
begun=""
rm -f "$build/failures"
together() {
    name=$1
    shift
    log=$(mktemp -p "$build")
    echo "$name" >"$log.name"
    { "$build/undisturbed" sh "$@"; echo $? >"$log.status"; date +%s >"$log.end"; } >"$log" 2>&1 &
    now >"$log.start"
    begun="$begun $log:$!"
}
ended() { # LOG PID
    wait "$2"
    cat "$1"
    grep -A 20 '^FAILED' "$1" | grep -v '^ok ' >>"$build/failures"
    echo "run.sh: it ran $(($(cat "$1.end") - $(cat "$1.start"))) s beside the others"
    return "$(cat "$1.status")"
}
all_together() {
    for one in $begun; do
        part "$(cat "${one%:*}.name")" ended "${one%:*}" "${one#*:}"
    done
}
politely() {
    if [ "${SKIP_OWN_CHECKS:-0}" = 1 ]; then "$@"; else nice -n 19 "$@"; fi
}

# The compiler takes most of the time, so sources whose tests run only a moment are not optimised; in an emulator all
# are. The optimised objects are linked first: the linker takes the first copy of an inline function, and without
# optimisation the simulated drives take ten times as long.
busy=$(grep -v '^#' tests/run/busy.txt)
quickly=-O0
[ -z "${RUNNER:-}" ] || quickly=-O1

# Names of sources are plain, so that word splitting is harmless.
sources=$(for source in tests/run/*.cpp tests/run/*/*.cpp tests/static/*.cpp; do
    name=${source#tests/run/}
    case " $(echo $busy) " in
    *" ${name%.cpp} "*) [ "${QUICK:-0}" = 1 ] || echo "1 $source" ;;
    *) echo "2 $source" ;;
    esac
done | sort -s -k1,1 | cut -d' ' -f2)
objects=""
for source in $sources; do
    objects="$objects $build/$(echo "${source%.cpp}" | tr / _).o"
done

# The headers that most sources include are precompiled once for each level, but not for an emulator: cross compilers of
# g++ 12 crash with a precompiled header. A compiler that cannot use it reports that (-Winvalid-pch) and never uses the
# text instead.
precompile() { # LEVEL
    mkdir -p "$build/pch$1"
    echo '#error "the precompiled header was not used"' >"$build/pch$1/precompiled.hpp"
    case $($CXX --version) in *clang*) ending=pch ;; *) ending=gch ;; esac
    politely $CXX $flags "$1" -x c++-header tests/support/precompiled.hpp -o "$build/pch$1/precompiled.hpp.$ending"
}

compile_all() {
    rm -f $objects
    echo "run.sh: building $(echo "$sources" | wc -l) sources with $CXX"
    if [ -z "${RUNNER:-}" ]; then
        { precompile "$quickly" & precompile_quickly=$!; precompile -O1 && wait $precompile_quickly; } || return 1
    fi
    echo "$sources" | politely xargs -P "${JOBS:-2}" -I{} sh -c '
        source=$1; build=$2; quickly=$3; busy=$4; shift 4
        name=${source#tests/run/}
        case " $busy " in *" ${name%.cpp} "*) level=-O1 ;; *) level=$quickly ;; esac
        # A source with its own macros is compiled without the precompiled header.
        [ ! -d "$build/pch$level" ] || grep -q "^#define" "$source" || set -- "$@" -Winvalid-pch -include "$build/pch$level/precompiled.hpp"
        "$@" "$level" -c "$source" -o "$build/$(echo "${source%.cpp}" | tr / _).o" || exit 255' \
        compile {} "$build" "$quickly" "$(echo $busy)" $CXX $flags || return 1
    $CXX $flags $objects -o "$build/tests"
}

# Runs the tests in parallel parts and adds their summaries. Every test case must be in a part.
run_all() {
    compile_all || return 1
    echo "run.sh: built in $(($(now) - start)) s"
    count=$(${RUNNER:-} "$build/tests" --count ${TEST_ARGUMENTS:-} --no-version | grep -o '[0-9]*$')
    [ "${count:-0}" -gt 0 ] || return 1
    rm -f "$build"/part.*
    seq 1 "$at_a_time" "$count" | politely xargs -P "${JOBS:-2}" -I{} sh -c '
        first=$1 last=$(($1 + $2 - 1)) build=$3; shift 3
        "$@" --first="$first" --last="$last" --no-version --duration=true >"$build/part.$first" 2>&1
        echo "status $?" >>"$build/part.$first"' \
        run {} "$at_a_time" "$build" ${RUNNER:-} "$build/tests" ${TEST_ARGUMENTS:-}
    grep -L '^status 0$' "$build"/part.* | sort -V | xargs -r cat | grep -vE '^[0-9.]+ s: '
    echo "run.sh: the slowest tests"
    cat "$build"/part.* | grep -E '^[0-9.]+ s: ' | sort -rn | head -n 5 | sed 's/^/    /'
    cat "$build"/part.* | sed 's/[|]/ /g' | awk -v wanted="$count" '
        /^[0-9.]+ s: / { cases++ }
        /^\[doctest\] test cases:/ { failed += $7 }
        /^\[doctest\] assertions:/ { checks += $3; good += $4; bad += $6 }
        /^status/ { runs++; if ($2 != 0) broken++ }
        END {
            printf "[doctest] test cases: %d | %d passed | %d failed\n", cases, cases - failed, failed
            printf "[doctest] assertions: %d | %d passed | %d failed\n", checks, good, bad
            if (cases != wanted) printf "run.sh: %d test cases were to run\n", wanted
            is_good = runs > 0 && broken == 0 && failed == 0 && cases == wanted
            print "[doctest] Status: " (is_good ? "SUCCESS!" : "FAILURE!")
            exit !is_good
        }'
}
at_a_time=10

# The tool has many sources, so they are compiled in parallel.
build_tools() {
    programs=$(ls examples/servobus/*.cpp examples/wheels/main.cpp examples/stepper/main.cpp examples/servo/main.cpp)
    mkdir -p "$build/examples"
    echo "$programs" | politely xargs -P "${JOBS:-2}" -I{} sh -c '
        source=$1; build=$2; shift 2
        "$@" -c "$source" -o "$build/$(echo "${source%.cpp}" | tr / _).o" || exit 255' \
        compile {} "$build/examples" $CXX -std=c++20 -O1 -Iinclude ${CXXFLAGS:-} &&
        $CXX ${CXXFLAGS:-} "$build"/examples/examples_servobus_*.o -o "$build/servobus" || return 1
    for program in wheels stepper servo; do
        $CXX ${CXXFLAGS:-} "$build/examples/examples_${program}_main.o" -o "$build/$program" || return 1
    done
    $CXX -std=c++20 -O1 tests/support/undisturbed.cpp -o "$build/undisturbed" && ! "$build/undisturbed" false
}

began=$(now)
if [ "${SKIP_OWN_CHECKS:-0}" != 1 ]; then
    part "tools' build" build_tools
    for file in tests/tool/*.sh; do
        tool_part=$(basename "$file" .sh)
        together "tool's $tool_part" tests/tool.sh "$build/servobus" "$tool_part"
    done
    for program in wheels stepper servo; do
        together "$program program" "tests/$program.sh" "$build/servobus" "$build/$program"
    done
    part "wrong programs" politely sh tests/fail/run.sh "$CXX"
    part "page of compile errors" sh tests/fail/page.sh --check
fi
part "tests" run_all
all_together
echo "run.sh: $(($(now) - began)) s in all"

if [ "$failed" = 0 ]; then
    echo "run.sh: all passed ($CXX): ${summary%, }"
else
    # Once more, where the end of a long log shows them.
    [ ! -s "$build/failures" ] || { echo "run.sh: what failed:"; cat "$build/failures"; }
    echo "run.sh: FAILED ($CXX): ${summary%, }"
fi
exit "$failed"
