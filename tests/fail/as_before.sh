#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Prints what a compiler prints of a program. It runs only if its command, the compiler, the program, or a file that was
# included has changed since it ran; else its last words are printed again, and that it did not run.
#   sh as_before.sh RECORD COMPILER ARGUMENT...
#   RECORD    a path of a build folder: RECORD.words, RECORD.files and RECORD.command are written
set -u
record=$1
shift
compiler=$(command -v "$1") || { echo "as_before.sh: there is no $1"; exit 2; }

is_as_before() {
    [ -e "$record.words" ] && [ "$(cat "$record.command")" = "$*" ] || return 1
    # A file that is gone is an error of find, so that it counts as changed.
    # shellcheck disable=SC2046
    newer=$(find -L "$compiler" $(cat "$record.files") -newer "$record.command" 2>&1) && [ -z "$newer" ]
}
if is_as_before "$@"; then
    echo "as before: $compiler did not run"
    cat "$record.words"
    exit 0
fi
rm -f "$record.words"
echo "$*" >"$record.command" # older than what changes while it runs
before=''
precompiled=''
for last in "$@"; do
    [ "$before" != -include-pch ] || precompiled=$last # -H says nothing of what is in it
    before=$last
done
"$@" -H >"$record.all" 2>&1
{
    echo "$last"
    [ -z "$precompiled" ] || echo "$precompiled"
    sed -n 's/^\.\.* //p' "$record.all"
} >"$record.files"
sed '/^\.\.* /d; /^Multiple include guards/,$d' "$record.all" >"$record.words"
rm -f "$record.all"
cat "$record.words"
# A compiler that was killed or crashed has said nothing of the program: it runs again.
! grep -qE 'internal compiler error|Killed|PLEASE submit a bug report' "$record.words" || rm -f "$record.words"
