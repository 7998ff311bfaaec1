#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The POSIX ports as other systems than Linux have them, run on Linux: SERVOBUS_PORTABLE_POSIX leaves out what only Linux
# has. Their tests, and the command-line tool with its simulated drives.   sh tests/portable.sh
#   CXX    the compiler, g++ if not given
#   JOBS   sources compiled at a time, 2 if not given
# What it cannot show: headers and drivers of those systems. The last line is a summary.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
echo '#include <doctest/doctest.h>' | $CXX -x c++ -fsyntax-only - 2>/dev/null || must_install doctest-dev
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
tests="tests/run/main.cpp tests/run/posix/posix.cpp tests/run/posix/tcp.cpp tests/run/line/mbap_port.cpp"
flags="-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -DSERVOBUS_PORTABLE_POSIX -Iinclude -I."

# By a variable, since what a script names is what it judges (unless_unchanged.py): of the tool os/ and streams/ alone.
programs=examples
# shellcheck disable=SC2086
ls "$programs/servobus.cpp" $tests | xargs -P "${JOBS:-2}" -I{} sh -c '
    source=$1; build=$2; shift 2
    "$@" -c "$source" -o "$build/$(basename "$source").o" || exit 255' compile {} "$build" $CXX $flags ||
    { echo "portable.sh: FAILED, it does not compile"; exit 1; }
$CXX "$build/servobus.cpp.o" -o "$build/servobus" && rm "$build/servobus.cpp.o" && $CXX "$build"/*.o -o "$build/tests" || exit 1
if nm -C "$build/servobus" | grep -qE ' U (ppoll|prctl|ptsname_r)\b'; then
    echo "portable.sh: FAILED, it calls what only Linux has"
    exit 1
fi
status=0
"$build/tests" || status=1
for part in zlac8015d scan parameters output; do python3 -B tests/tool/$part.py "$build/servobus" || status=1; done
[ $status = 0 ] && echo "portable.sh: passed" || echo "portable.sh: FAILED"
exit $status
