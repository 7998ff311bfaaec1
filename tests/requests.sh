#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Compares which requests the tests of drives and buses send with those of another revision, test case by test case: for
# changes that are to change none. The simulated clocks do not advance while a program only asks for the time, so that a call of
# `now()` more or less makes no difference. Installs missing packages first (Debian, Ubuntu).
#   sh tests/requests.sh REVISION [ARGUMENT...]
#   FOLDER     keeps copies, builds and records, /var/tmp/servobus-requests if not set: the next run builds what has changed
#   ARGUMENT   of the tests' program, such as '--test-case=*restart*'
#   REQUESTS_OF  a part of a test case's name, whose requests are written to both records, to be compared by `diff`
# Prints the test cases that differ; the last line is a summary. The status is 1 if any differs.
set -u
cd "$(dirname "$0")/.." || exit 2
[ $# -ge 1 ] || { echo "usage: sh tests/requests.sh REVISION [ARGUMENT...]" >&2; exit 2; }
revision=$(git rev-parse --verify --quiet "$1^{commit}") || { echo "requests.sh: no revision $1" >&2; exit 2; }
shift

. tests/support/install.sh
for tool in cmake ninja:ninja-build python3 g++ git; do
    command -v "${tool%%:*}" >/dev/null 2>&1 || must_install "${tool##*:}"
done
[ -e /usr/include/doctest/doctest.h ] || must_install doctest-dev

folder=${FOLDER:-/var/tmp/servobus-requests}
mkdir -p "$folder/before" "$folder/after" "$folder/fresh" || exit 2

# copy NAME: the tree in fresh/ becomes that of NAME; unchanged files keep their time.
copy() {
    python3 -B tests/requests/requests.py place "$folder/fresh" "$folder/$1" || exit 2
    rm -rf "$folder/fresh"
    mkdir "$folder/fresh"
}
rm -rf "$folder/fresh" && mkdir "$folder/fresh"
git archive "$revision" | tar -x -C "$folder/fresh"
copy before
git ls-files -z --cached --others --exclude-standard | xargs -0 sh -c '
    for file; do [ ! -e "$file" ] || printf "%s\0" "$file"; done' - | tar -c --null -T - | tar -x -C "$folder/fresh"
copy after
for tree in before after; do
    echo "requests.sh: $tree: building"
    python3 -B tests/requests/requests.py record "$folder/$tree" "$folder/build-$tree" "$folder/$tree.txt" "$@" || exit 2
done
python3 -B tests/requests/requests.py compare "$folder/before.txt" "$folder/after.txt"
