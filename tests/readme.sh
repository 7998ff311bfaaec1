#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Compiles every C++ block of the README on its own.   sh tests/readme.sh [COMPILER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
awk -v work="$work" '/^```cpp$/ { inside = 1; file = sprintf("%s/block%d.cpp", work, ++n); next }
                     /^```$/ { inside = 0 }
                     inside { print > file }' README.md
blocks=0
for block in "$work"/block*.cpp; do
    "${1:-${CXX:-g++}}" -std=c++20 -O2 -Wall -Wextra -Werror -Iinclude -c "$block" -o "$work/block.o"
    blocks=$((blocks + 1))
done
[ "$blocks" -ge 3 ] || { echo "readme.sh: only $blocks blocks found"; exit 1; }
echo "readme.sh: $blocks blocks of the README compile"
