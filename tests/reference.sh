#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the reference (examples/reference/make.sh), twice, and checks it (tests/reference/check.py): doxygen has no warning;
# every link leads somewhere; every register is on its drive's page once, with the words of its manual; client::read
# has its summary and errors; in a real browser, at a phone's width and a desk's, the filter works and nothing is wider
# than the page.
#
#   sh tests/reference.sh
#   SERVOBUS=PATH sh tests/reference.sh    with a tool that is built already
set -u
cd "$(dirname "$0")/.." || exit 1

missing=""
command -v doxygen >/dev/null 2>&1 || missing="$missing doxygen"
command -v python3 >/dev/null 2>&1 || missing="$missing python3"
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[ -n "$browser" ] || missing="$missing chromium"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    must_install $missing
    [ -n "$browser" ] || browser=$(command -v chromium) || { echo "reference.sh: no browser"; exit 1; }
fi
CXX=${CXX:-g++}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
failed=0

tool=${SERVOBUS:-}
if [ -z "$tool" ]; then
    tool=$work/servobus
    "$CXX" -std=c++20 -O0 -Iinclude examples/servobus/*.cpp examples/servobus/*/*.cpp -o "$tool" || exit 1
fi

for run in pages again; do
    SERVOBUS=$tool sh examples/reference/make.sh "$work/$run" >"$work/said" 2>&1 || {
        cat "$work/said"
        echo "FAILED  the reference is not built"
        exit 1
    }
done
echo "ok      built, and doxygen has no warning"
if diff -r "$work/pages" "$work/again" >"$work/differs"; then
    echo "ok      a second run gives the same bytes"
else
    head -n 5 "$work/differs" | cut -c 1-200
    echo "FAILED  a second run gives other bytes"
    failed=1
fi
rm -rf "$work/again"

# A comment that doxygen cannot read must end the build with an error.
mkdir -p "$work/tree/examples" "$work/tree/tests" &&
    cp -r include CMakeLists.txt "$work/tree/" && cp -r examples/reference "$work/tree/examples/" &&
    cp -r tests/support "$work/tree/tests/" && printf '%s\n' '/// See @ref no_such_thing.' 'struct spoilt {};' \
    >>"$work/tree/include/servobus/core/version.hpp"
if SERVOBUS=$tool sh "$work/tree/examples/reference/make.sh" "$work/spoilt" >"$work/said" 2>&1 ||
    ! grep -q 'no_such_thing' "$work/said"; then
    echo "FAILED  a wrong comment is not noticed"
    failed=1
else
    echo "ok      a wrong comment is noticed"
fi

python3 -B tests/reference/check.py "$work/pages" "$tool" "$browser" "$work" || failed=1
[ "$failed" = 0 ] && echo "reference.sh: passed" || echo "reference.sh: FAILED"
exit "$failed"
