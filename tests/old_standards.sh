#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Checks that a compiler which is not set to C++20 is refused by a sentence, before any other error, in each header that
# a program may include; and that MSVC's macro decides where it is defined.   sh tests/old_standards.sh [COMPILER...]
set -u
cd "$(dirname "$0")/.." || exit 1
[ $# -gt 0 ] || set -- g++ clang++
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
fails() { failed=1; echo "old_standards.sh: $1"; head -n 3 "$work/said"; }

sentence='servobus needs C++20'
headers=$(find include/servobus -name '*.hpp' ! -path '*/detail/*' ! -path '*/windows/*' | sort)
count=0
for compiler in "$@"; do
    for header in $headers; do
        count=$((count + 1))
        echo "#include <${header#include/}>" >"$work/main.cpp"
        if $compiler -std=c++17 -Iinclude -fsyntax-only "$work/main.cpp" >"$work/said" 2>&1; then
            fails "$compiler -std=c++17 compiles $header"
        elif ! grep 'error' "$work/said" | head -n 1 | grep -qF "$sentence"; then
            fails "$compiler -std=c++17, $header: the first error is not \"$sentence\""
        fi
    done
    # As MSVC without /Zc:__cplusplus.
    echo '#include <servobus/core/cxx20.hpp>' >"$work/main.cpp"
    msvc() { $compiler -Wno-builtin-macro-redefined -U__cplusplus -D__cplusplus=199711L "-D_MSVC_LANG=$1" -E -Iinclude "$work/main.cpp" >"$work/said" 2>&1; }
    msvc 202002L || fails "$compiler: _MSVC_LANG of C++20 is refused"
    ! msvc 201703L || fails "$compiler: _MSVC_LANG of C++17 is accepted"
    grep -qF '/std:c++20' "$work/said" || fails "$compiler: the option of MSVC is not named"
done
[ "$failed" = 0 ] && echo "old_standards.sh: $count headers refuse C++17, by $*" || echo "old_standards.sh: FAILED"
exit "$failed"
