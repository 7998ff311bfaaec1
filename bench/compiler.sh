# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Measures the compiler itself. compile_cost.sh and include_cost.sh source this file. They set `extra`, the packages
# that they need themselves. This file sets `work`, a folder that is removed at the end, `flags` and `instructions`.
missing=$extra
command -v g++ >/dev/null 2>&1 || missing="$missing g++"
command -v valgrind >/dev/null 2>&1 || missing="$missing valgrind"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    # shellcheck disable=SC2086
    must_install $missing
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
flags="-std=c++20 -fsyntax-only -Iinclude"
instructions() { # FILE: the instructions that the compiler proper (cc1plus) executes
    # shellcheck disable=SC2086
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --trace-children=yes g++ $flags "$1" 2>"$work/log" ||
        { cat "$work/log" >&2; return 1; }
    sed -n 's/.*Collected : *\([0-9]*\).*/\1/p' "$work/log" | sort -n | tail -1
}
