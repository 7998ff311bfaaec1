#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Checks that the version is the same in the header, CMakeLists.txt and meson.build, and in the given pkg-config
# files.   sh tests/version.sh [FILE.pc...]
set -u
cd "$(dirname "$0")/.." || exit 1
in_header=$(sed -n 's/^inline constexpr version_number version{\([0-9]*\), \([0-9]*\), \([0-9]*\)};$/\1.\2.\3/p' \
    include/servobus/core/version.hpp)
failed=0
[ -n "$in_header" ] || { echo "version.sh: no version in core/version.hpp"; exit 1; }
same() { # WHERE VERSION
    [ "$2" = "$in_header" ] && return
    echo "version.sh: $1 says '$2', core/version.hpp $in_header"
    failed=1
}
same CMakeLists.txt "$(sed -n 's/^project(servobus VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)"
same meson.build "$(sed -n "s/^project('servobus'.* version: '\([0-9.]*\)'.*/\1/p" meson.build)"
for file in "$@"; do same "$file" "$(sed -n 's/^Version: *//p' "$file")"; done
[ "$failed" = 0 ] && echo "version.sh: $in_header everywhere"
exit "$failed"
