#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# S8: the servo program asks for consent before it moves a real machine, and stops it on a signal and on every error.
#   sh tests/servo.sh TOOL SERVO      the two built programs
set -u
tool=$1
servo=$2
. "$(dirname "$0")/support/simulated_job.sh"

held() { # the value of a parameter in the simulated drive
    "$tool" read "$work/drive" c630s "$1" | cut -d= -f2
}
start_servo() { # WORDS: starts the program and waits until it prints the words
    : >"$work/out" # removes the output of the run before
    "$servo" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1 &
    program=$!
    until grep -q "$1" "$work/out"; do kill -0 "$program" || break; sleep 0.1; done
    sleep 0.7
}

start_simulator c630s
"$servo" >"$work/out" 2>&1
check "S8: without a port it says how to call it" 2 $?
"$servo" /nowhere/at/all --simulator 1 >"$work/out" 2>&1
check "S8: a port that is not there is an error" 1 $?
echo "no" | "$servo" "$work/drive" >"$work/out" 2>&1
check "S8: without the typed consent nothing happens" 2 $?
check "S8: and it says so" 1 "$(grep -c 'Nothing was sent' "$work/out")"
check "S8: the drive was not touched" "200 r/min" "$(held target_speed)"

"$servo" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1
check "the program runs to its end" 0 $?
check "a turn forward ends on its target" 1 "$(grep -c '  0.0 r/min *10000 units' "$work/out")"
check "the motor is at rest" 1 "$(grep -c 'the motor is at rest' "$work/out")"
check "G17: writes are not kept any more" "off (0x0000)" "$(held eeprom_update)"
check "servo off" "vdi16 (0x8000)" "$(held virtual_input_levels)"

for signal in INT TERM; do
    start_servo "turning"
    kill -s "$signal" "$program"
    wait "$program"
    check "S8: SIG$signal while the motor turns ends it with an error" 1 $?
    check "S8: SIG$signal leaves the servo off" "vdi16 (0x8000)" "$(held virtual_input_levels)"
    check "S8: SIG$signal leaves the motor standing" "0 r/min" "$(held actual_speed)"
done

start_servo "turning"
kill -KILL "$simulator"
wait "$simulator" 2>/dev/null
simulator=""
wait "$program"
check "S8: a drive that dies under it ends it with an error" 1 $?
check "S8: a stop that no one confirmed is said" 1 "$(grep -c 'stop was not confirmed' "$work/out")"

echo "servo.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
