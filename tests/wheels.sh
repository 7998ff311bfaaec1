#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# S8: the wheel program asks for consent before it moves a real machine, and stops it on a signal and on every error.
#   sh tests/wheels.sh TOOL WHEELS      the two built programs
set -u
tool=$1
wheels=$2
. "$(dirname "$0")/support/simulated_job.sh"

running() { # the status word of the simulated drive
    "$tool" read "$work/drive" zlac8015d status_word | cut -d= -f2
}

start_simulator zlac8015d
"$wheels" >"$work/out" 2>&1
check "S8: without a port it says how to call it" 2 $?
"$wheels" /nowhere/at/all --simulator 1 >"$work/out" 2>&1
check "S8: a port that is not there is an error" 1 $?
check "S8: with the system's reason" "wheels: cannot open /nowhere/at/all: No such file or directory" "$(cat "$work/out")"
echo "no" | "$wheels" "$work/drive" >"$work/out" 2>&1
check "S8: without the typed consent nothing happens" 2 $?
check "S8: and it says so" 1 "$(grep -c 'Nothing was sent' "$work/out")"
check "S8: the drive was not touched" "undefined" \
    "$("$tool" read "$work/drive" zlac8015d mode_of_operation | cut -d= -f2 | cut -d' ' -f1)"

turn_wheels() { # starts the program and waits until the wheels turn
    : >"$work/out" # removes the output of the run before
    "$wheels" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1 &
    program=$!
    until grep -q "turning" "$work/out"; do kill -0 "$program" || break; sleep 0.1; done
}
for signal in INT TERM; do
    turn_wheels
    kill -s "$signal" "$program"
    wait "$program"
    check "S8: SIG$signal while the wheels turn ends it with an error" 1 $?
    check "S8: SIG$signal leaves the drive stopped and released" "left_released+right_released (0x0000)" "$(running)"
done

# Whether a sign is forward depends on how the motors are mounted, and a fraction of a turn on the encoder.
"$wheels" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1
check "the whole job" 0 $?
check "no direction of a robot and no fraction of a turn is claimed" 0 \
    "$(grep -cE 'on the spot|forward|half a turn|quarter' "$work/out")"

turn_wheels
kill -KILL "$simulator"
wait "$simulator" 2>/dev/null
simulator=""
wait "$program"
check "S8: a drive that dies under it ends it with an error" 1 $?
check "S8: a stop that no one confirmed is said" 1 "$(grep -c 'stop was not confirmed' "$work/out")"

echo "wheels.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
