#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Each wrong program must fail to compile, and its error must contain the sentence after "EXPECT:"; control.cpp,
# the same programs mended, must compile.   sh tests/fail/run.sh [COMPILER]
set -u
cd "$(dirname "$0")/../.." || exit 1
CXX=${1:-${CXX:-g++}}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
programs=0

if ! $CXX -std=c++20 -Wall -Wextra -Werror -Iinclude -fsyntax-only tests/fail/control.cpp >"$work/control" 2>&1; then
    echo "FAILED  control.cpp does not compile, so the others prove nothing:"
    head -n 20 "$work/control"
    failed=1
fi
# control.cpp without blanks and without the numbers that keep its names apart.
plain() { tr -d ' \n' | sed -E 's/(gain|request|frame|plan)_[0-9]+/\1/g'; }
control=$(plain <tests/fail/control.cpp)
mend_of() {
    awk '/^\/\/ MEND: / { text = substr($0, 10); inside = 1; next }
         inside && /^\/\/ / { text = text substr($0, 4); next }
         { inside = 0 }
         END { print text }' "$1" | plain
}

# What the compiler says of each; a program that compiles leaves a mark.
ls tests/fail/*.cpp | xargs -P "${JOBS:-2}" -I{} sh -c '
    source=$1; said=$2/$(basename "$1" .cpp); shift 2
    if "$@" "$source" >"$said" 2>&1; then : >"$said.compiles"; fi' \
    compile {} "$work" $CXX -std=c++20 -Iinclude -fsyntax-only

for source in tests/fail/*.cpp; do
    [ "$source" != tests/fail/control.cpp ] || continue
    programs=$((programs + 1))
    name=$(basename "$source" .cpp)
    expected=$(sed -n 's|^// EXPECT: ||p' "$source")
    if [ -z "$expected" ]; then
        echo "FAILED  $name: no line \"// EXPECT:\""
        failed=$((failed + 1))
    elif mend=$(mend_of "$source") && [ -z "$mend" ]; then
        echo "FAILED  $name: no line \"// MEND:\""
        failed=$((failed + 1))
    elif [ "${control#*"$mend"}" = "$control" ]; then
        echo "FAILED  $name: its mend is not in control.cpp"
        failed=$((failed + 1))
    elif [ -e "$work/$name.compiles" ]; then
        echo "FAILED  $name: it compiles"
        failed=$((failed + 1))
    elif ! grep -E '(error|note)[: ]|in call to|static assertion' "$work/$name" | grep -qF -e "$expected"; then
        echo "FAILED  $name: the error does not say \"$expected\":"
        head -n 12 "$work/$name"
        failed=$((failed + 1))
    fi
done
echo "fail/run.sh: $programs wrong programs, $failed failed ($CXX)"
[ "$failed" = 0 ]
