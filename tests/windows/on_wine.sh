#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Plays the command-line tool for tests/tool.sh: $SERVOBUS_EXE on wine; the simulated drives are those of $SERVOBUS, the
# tool of this machine. A terminal among the arguments becomes COM20.
#
# A response passes through wine's server, which on a busy machine takes longer than the limit of a drive. So reads and
# writes at a port wait two seconds, unless the test says how long.
#
# Once in some thousand times wine ends a program before it begins. The tool never fails without a word, so a failure
# without one is wine's, and the program runs again. Not what runs until it is interrupted.
[ "$1" != sim ] || exec "$SERVOBUS" "$@"
left=$#
while [ "$left" -gt 0 ]; do
    word=$1
    shift
    if [ -c "$word" ]; then
        ln -sfn "$(readlink -f "$word")" "$WINEPREFIX/dosdevices/com20"
        word=COM20
    fi
    set -- "$@" "$word"
    left=$((left - 1))
done
case " $* " in
*" --timeout "* | *" --timeout="*) ;;
" read COM"* | " write COM"* | " watch COM"* | " backup COM"* | " restore COM"*) set -- "$@" --timeout 2000 ;;
esac
case $1 in watch | listen | restore) exec wine "$SERVOBUS_EXE" "$@" ;; esac
said=$(mktemp -d)
for attempt in 1 2 3; do
    wine "$SERVOBUS_EXE" "$@" >"$said/out" 2>"$said/err"
    status=$?
    [ "$status" != 0 ] && [ ! -s "$said/out" ] && [ ! -s "$said/err" ] || break
    echo "wine, attempt $attempt: status $status without a word: $*" >>"$SERVOBUS_EXE.again"
done
cat "$said/out"
cat "$said/err" >&2
rm -rf "$said"
exit "$status"
