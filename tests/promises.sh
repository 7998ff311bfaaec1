#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Compares the list of promises, include/servobus/promises.md, with the tests that name them and their errors.
#   sh tests/promises.sh           each promise has a test, each number in a test is a promise, the errors in the list
#                                  exist, and each errc is in the list
#   sh tests/promises.sh G19       prints the tests that name this promise
set -u
cd "$(dirname "$0")/.." || exit 1
list=include/servobus/promises.md
failed=0
bad() {
    echo "FAILED  $*"
    failed=$((failed + 1))
}

# Prints every number that the name of a test begins with, as "G19 file: name". A name may be on the line after its
# TEST_CASE, so lines are joined.
named() {
    for file in tests/run/*/*.cpp tests/sim/*.hpp tests/interop/*.cpp tests/ports/*pp tests/*.sh tests/tool/*.sh tests/interop/*.py tests/windows/*.py; do
        tr '\n' ' ' <"$file" | grep -oE '"([GS][0-9]+, )*[GS][0-9]+\b[^"]*"' |
            awk -v file="$file" '{ line = $0; while (match(line, /[GS][0-9]+/)) {
                print substr(line, RSTART, RLENGTH), file ": " $0; line = substr(line, RSTART + RLENGTH) } }'
    done
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
named >"$work/named"

if [ $# -gt 0 ]; then
    grep "^$1 " "$work/named" | cut -d' ' -f2-
    exit
fi

grep -oE '^\| [GS][0-9]+ ' "$list" | tr -d '| ' | sort >"$work/promised"
cut -d' ' -f1 "$work/named" | sort -u >"$work/tested"
for one in $(comm -23 "$work/promised" "$work/tested"); do bad "no test names $one"; done
for one in $(comm -13 "$work/promised" "$work/tested"); do bad "$one is named by a test and is no promise"; done

awk -F' [|] ' '/^[|] [GS]/ { print $3 }' "$list" >"$work/said"
sed -n '/^enum class errc/,/^};/p' include/servobus/core/status.hpp | grep -oE '^    [a-z_]+' | tr -d ' ' |
    grep -vx ok >"$work/errors"
while read -r error; do
    grep -q "\`$error\`" "$work/said" || bad "$error is in the list of no promise"
done <"$work/errors"
sed -n '/^enum class outcome/,/^};/p' include/servobus/core/status.hpp | grep -oE '^    [a-z_]+' | tr -d ' ' >>"$work/errors"
sed -n 's|^// EXPECT: ||p' tests/fail/*.cpp >>"$work/errors"
grep -oE '`[^`]*`' "$work/said" | tr -d '`' | sort -u >"$work/words"
while read -r word; do grep -qF "$word" "$work/errors" || bad "nothing says '$word'"; done <"$work/words"
grep -oE '"[^"]*"' "$work/said" | tr -d '"' | sort -u >"$work/quoted"
while read -r words; do grep -rqF "$words" examples || bad "no program says '$words'"; done <"$work/quoted"

echo "promises.sh: $(wc -l <"$work/promised") promises, $(wc -l <"$work/named") namings in tests, $failed failed"
[ "$failed" = 0 ]
