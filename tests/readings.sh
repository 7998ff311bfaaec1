#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Runs the safety tests in every combination of the switches of their simulated drive. The switches stand for readings
# of a manual that is incomplete or ambiguous. The tests are those of the test suite "readings" in
# tests/run/*/*DRIVE*.cpp; the usual run of the tests has only every pair of positions.   sh tests/readings.sh
# [DRIVE...]
#   DRIVE      zlac8015d, yako, c630s; all of them if none is given
#   CXX        the compiler, g++ if not given
#   CXXFLAGS   flags after the usual ones
#   JOBS       programs at a time, 2 if not given
# The last line for each drive gives the number of combinations and scenes that ran.
set -u
cd "$(dirname "$0")/.." || exit 1
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
usual="-std=c++20 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
flags="$usual -D_GLIBCXX_ASSERTIONS -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I. ${CXXFLAGS:-}"
[ $# -gt 0 ] || set -- zlac8015d yako c630s

for drive in "$@"; do
    sources=$(grep -l 'test_suite("readings")' tests/run/*/*"$drive"*.cpp 2>/dev/null)
    if [ -z "$sources" ]; then
        echo "readings.sh: no test of $drive is in the test suite \"readings\""
        exit 1
    fi
    echo "tests/run/main.cpp $sources" | tr ' ' '\n' | xargs -P "${JOBS:-2}" -I{} sh -c '
        source=$1; build=$2; shift 2
        "$@" -c "$source" -o "$build/$(echo "$source" | tr / _).o" || exit 255' \
        compile {} "$build" ${CXX:-g++} $flags || exit 1
    ${CXX:-g++} $flags "$build"/*.o -o "$build/$drive" || exit 1
    rm "$build"/*.o
done

# Each test case by itself, so that several run at a time.
failed=0
for drive in "$@"; do
    "$build/$drive" --test-suite=readings --list-test-cases --no-version | grep -v '^\[doctest\]\|^=' |
        tr '\n' '\0' | SERVOBUS_READINGS=whole xargs -0 -P "${JOBS:-2}" -I{} sh -c '
            name=$(printf "%s" "$2" | sed "s/[,\\\\]/?/g")
            log=$(mktemp -p "$3")
            "$1" --no-version --test-suite=readings --test-case="$name" >"$log" 2>&1 && rc=0 || rc=1
            [ $rc = 0 ] && grep "^readings: " "$log" || { head -n 40 "$log"; tail -n 4 "$log"; }
            grep "^readings: " "$log" >>"$3/scenes"
            exit $rc' run "$build/$drive" {} "$build" || failed=1
    [ -f "$build/scenes" ] || failed=1
    sed 's/^readings: [^:]*: \([0-9]*\) choices, \([0-9]*\) scenes.*/\1 \2/' "$build/scenes" |
        awk -v drive="$drive" '{ n++; if ($1 > most) most = $1; choices += $1; scenes += $2 }
            END { print "readings.sh: " drive ": " n " tests, up to " most " choices each, " choices \
                  " in all, " scenes " scenes" }'
    rm -f "$build/scenes"
done
[ "$failed" = 0 ] || echo "readings.sh: FAILED"
exit "$failed"
