#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The stepper program does its job on a simulated drive. S8: it asks for consent before it moves a real machine, and
# stops it on a signal and on every error.
#   sh tests/stepper.sh TOOL STEPPER      the two built programs
set -u
tool=$1
stepper=$2
. "$(dirname "$0")/support/simulated_job.sh"

# Values read from the simulated drive.
register() { "$tool" read "$work/drive" yako-closed-loop "$1" | cut -d= -f2 | cut -d' ' -f1; }
is_moving() { register status_word | grep -c moving; }

# Starts the program and waits until it prints the words.
start_until() { # WORDS
    : >"$work/out" # removes the output of the run before
    "$stepper" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1 &
    program=$!
    until grep -q "$1" "$work/out"; do kill -0 "$program" || break; sleep 0.1; done
}

start_simulator yako-closed-loop
"$stepper" >"$work/out" 2>&1
check "S8: without a port it says how to call it" 2 $?
"$stepper" /nowhere/at/all --simulator 1 >"$work/out" 2>&1
check "S8: a port that is not there is an error" 1 $?
echo "no" | "$stepper" "$work/drive" >"$work/out" 2>&1
check "S8: without the typed consent nothing happens" 2 $?
check "S8: and it says so" 1 "$(grep -c 'Nothing was sent' "$work/out")"
check "S8: the drive was not touched" 60 "$(register positioning_speed)"

"$stepper" "$work/drive" --simulator "$simulator" >"$work/out" 2>&1
check "it homes, positions, creeps and stops" 0 $?
check "and says that the axis is at rest" 1 "$(grep -c 'the axis is at rest' "$work/out")"
check "at zero, where it homed" 0 "$(register actual_position)"
check "30 r/min at most" 30 "$(register positioning_speed)"

for signal in INT TERM; do
    start_until "positioning"
    sleep 0.5
    kill -s "$signal" "$program"
    wait "$program"
    check "S8: SIG$signal while the axis moves ends it with an error" 1 $?
    check "S8: SIG$signal leaves the axis standing" 0 "$(is_moving)"
done

start_until "homing"
kill -s INT "$program"
wait "$program"
check "S8: SIGINT does not wait for the end of a homing" 1 $?
check "S8: and leaves the axis standing" 0 "$(is_moving)"

start_until "creeping"
kill -KILL "$program"
wait "$program" 2>/dev/null
sleep 2
check "S4: a creep ends by itself when its program is killed" 0 "$(is_moving)"

start_until "positioning"
kill -KILL "$simulator"
wait "$simulator" 2>/dev/null
simulator=""
wait "$program"
check "S8: a drive that dies under it ends it with an error" 1 $?
check "S8: a stop that no one confirmed is said" 1 "$(grep -c 'stop was not confirmed' "$work/out")"

echo "stepper.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
