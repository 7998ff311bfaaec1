#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Makes the page of compile errors, README.md, from the wrong programs beside it.   sh tests/fail/page.sh [--check]
# With --check it writes nothing and fails if the page is not what it would make.
set -eu
cd "$(dirname "$0")"

page() {
    cat <<'HEAD'
# Compile errors and their mends

Each of these lines is wrong and does not compile. The compiler's error, often a dozen lines, contains the words
given here; look for them. `drive` is a client of a ZLAC8015D, `zlac` is `servobus::zlac8015d`, `units` is
`servobus::units`. This page is made by `page.sh` from the programs beside it, which the tests compile with g++ and
clang++.
HEAD
    for source in *.cpp; do
        [ "$source" != control.cpp ] || continue
        awk -v source="$source" '
            /^\/\/ EXPECT: / { words = substr($0, 12); next }
            /^\/\/ MEND: / { mend = substr($0, 10); inside = 1; next }
            inside && /^\/\/ / { mend = mend " " substr($0, 4); next }
            { inside = 0 }
            /^\/\/ SPDX/ || /^\/\/$/ { next }
            /^\/\/ / && !code { title = title (title == "" ? "" : " ") substr($0, 4); next }
            /^#include/ { code = 1; next }
            code { all[++lines] = $0; if ($0 ~ /\/\/ wrong$/) marked = lines }
            END {
                first = marked
                while (first > 1 && all[first] !~ /^ *(\(void\)|constexpr auto|inline constexpr)/) --first
                for (i = first; i <= marked; ++i) {
                    line = all[i]
                    sub(/ *\/\/ wrong$/, "", line)
                    sub(/^ */, "", line)
                    sub(/^\(void\)/, "", line)
                    wrong = wrong (i == first ? "" : "\n    ") line
                }
                sub(/^\(void\)/, "", mend)
                sub(/\.$/, "", title)
                printf "\n## %s\n\n```cpp\n%s\n```\n\nThe compiler says `%s`. Mend:\n\n```cpp\n%s\n```\n\n([%s](%s))\n",
                    title, wrong, words, mend, source, source
            }' "$source"
    done
}

if [ "${1:-}" = --check ]; then
    if page | cmp -s - README.md; then
        echo "fail/page.sh: the page of compile errors is up to date"
    else
        echo "fail/page.sh: README.md is out of date: run sh tests/fail/page.sh"
        exit 1
    fi
else
    page >README.md
fi
