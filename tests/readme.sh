#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Checks the pages of the project: each ```cpp block compiles on its own, and each relative link leads to an existing
# file, and to an existing heading if it names one. The page of compile errors has blocks that must not compile, so only
# its links are checked.   sh tests/readme.sh [COMPILER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
pages=$(git ls-files --cached --others --exclude-standard '*.md' 2>/dev/null || true)
[ -n "$pages" ] || pages=$(find . -name '*.md' ! -path './build*' | sed 's|^\./||' | sort)
failed=0

blocks=0
for page in $pages; do
    [ "$page" != tests/fail/README.md ] || continue
    rm -f "$work"/block*
    awk -v work="$work" '/^```cpp$/ { inside = 1; file = sprintf("%s/block%d.cpp", work, NR); next }
                         /^```$/ { inside = 0 }
                         inside { print > file }' "$page"
    for block in "$work"/block*.cpp; do
        [ -e "$block" ] || continue
        blocks=$((blocks + 1))
        "${1:-${CXX:-g++}}" -std=c++20 -O2 -Wall -Wextra -Werror -Iinclude -c "$block" -o "$work/block.o" || {
            echo "FAILED  $page: the block that begins in line $(basename "$block" .cpp | tr -d a-z)"
            failed=1
        }
    done
done

# The anchors of the headings of a page: lower case, - for each blank, otherwise only letters, digits, - and _.
anchors() { # PAGE
    awk '/^```/ { inside = !inside } !inside && /^#+ / { sub(/^#+ /, ""); print tolower($0) }' "$1" |
        sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}
# The links of a page, without those in `...` and in indented or fenced code.
links() { # PAGE
    awk '/^```/ { inside = !inside; next } !inside && !/^    / { print }' "$1" | sed 's/`[^`]*`//g' |
        grep -oE '\]\([^)]+\)' | sed 's/^](//; s/)$//' | grep -vE '^[a-z]+:' || true
}
checked=0
for page in $pages; do
    for link in $(links "$page"); do
        checked=$((checked + 1))
        file=${link%%#*}
        target=$page
        [ -z "$file" ] || target=$(dirname "$page")/$file
        if [ ! -e "$target" ]; then
            echo "FAILED  $page: the link $link leads to no file"
            failed=1
        elif [ "$link" != "$file" ] && ! anchors "$target" | grep -qxF -e "${link#*#}"; then
            echo "FAILED  $page: the link $link leads to no heading"
            failed=1
        fi
    done
done

[ "$blocks" -ge 8 ] || { echo "FAILED  only $blocks blocks found"; failed=1; }
[ "$checked" -ge 50 ] || { echo "FAILED  only $checked links found"; failed=1; }
echo "readme.sh: $blocks blocks of code, $checked links in $(echo "$pages" | wc -l) pages"
exit "$failed"
