#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Plays the command-line tool for tests/tool.sh: $SERVOBUS_EXE on wine; the simulated drives are those of $SERVOBUS, the
# tool of this machine. A terminal among the arguments becomes COM20.
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
exec wine "$SERVOBUS_EXE" "$@"
