# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: sim, read, write and watch with a simulated ZLAC8015D.

# sim, read, write

check "sim starts" start_sim zlac8015d
check "sim prints the pseudo-terminal" grep -q '^/dev/pts/' "$dir/sim.out"
check "sim prints one line" [ "$(wc -l <"$dir/sim.out")" -eq 1 ]
succeeds "read by name and by address" "bus_voltage=24.00 V
motor_temperature=31/32 degC
mode_of_operation=undefined (0x0000)" read "$drive" zlac8015d bus_voltage 0x20A4 mode_of_operation
succeeds "read with the node" "node_address=1" read "$drive" zlac8015d:1 node_address
succeeds "read raw" "0x20A1=2400 (0x0960)
0x2088=0 (0x0000)
0x2089=0 (0x0000)" read "$drive" raw 0x20A1 0x2088:2 --baud 115200
succeeds "options before and after the names" "bus_voltage=24.00 V" \
    read --timeout 500 "$drive" zlac8015d bus_voltage --retries=3 --baud 115200 --format 8N1 --echo off
succeeds "write in the register's unit" "left_max_current=12.5 A" write "$drive" zlac8015d left_max_current=12.5
succeeds "and read back" "left_max_current=12.5 A" read "$drive" zlac8015d left_max_current
succeeds "write bits by name" "input_polarity=x0+x1 (0x0003)" write "$drive" zlac8015d input_polarity=x0+x1
succeeds "write a negative pair" "left_target_position=-20480 pulse" \
    write "$drive" zlac8015d left_target_position=-20480 --yes
succeeds "and read it back" "left_target_position=-20480 pulse" read "$drive" zlac8015d left_target_position
succeeds "write raw, two words in a frame" "0x2088=50 (0x0032)
0x2089=65486 (0xFFCE)" write "$drive" raw 0x2088:2=50,-50 --yes --baud 115200
succeeds "hex is the content as it is" "right_target_speed=-100 r/min (at the factory's scale)" \
    write "$drive" zlac8015d right_target_speed=0xFF9C --yes
check "a target warns, and says that its counts are raw" err_has "raw counts"
succeeds "and none of them by a number" "input_polarity=0x0000" write "$drive" zlac8015d input_polarity=0
run write "$drive" zlac8015d left_target_speed=20 right_target_speed=20 mode_of_operation=velocity control_word=enable
check "S8: nothing is written that may move a machine before consent" status_is 1
check "S8: and it says so" err_has "not confirmed, nothing was written"
succeeds "S8: not even what precedes it" "mode_of_operation=undefined (0x0000)" \
    read "$drive" zlac8015d mode_of_operation
run write "$drive" raw 0x200E=8
check "S8: an address without a map may move it too" err_has "not confirmed, nothing was written"
"$tool" write "$drive" zlac8015d left_target_speed=20 right_target_speed=20 mode_of_operation=velocity \
    control_word=enable >"$dir/out" 2>"$dir/err" <<END
write
END
status=$?
check "several writes turn the wheels" status_is 0
turns() { [ "$("$tool" read "$drive" zlac8015d left_actual_speed)" = "left_actual_speed=20.0 r/min" ]; }
check "the wheel reaches its speed" until_true turns
run write "$drive" zlac8015d left_target_speed=0 control_word=stop
check "S8: a stop needs no consent" status_is 0

# A value that the register cannot hold is not sent

fails "no whole number of counts" 2 "no whole number of counts" write "$drive" zlac8015d left_max_current=12.55
fails "outside the range" 2 "is outside 0.0 A .. 30.0 A" write "$drive" zlac8015d left_max_current=31
fails "a negative one too" 2 "is outside" write "$drive" zlac8015d left_max_current=-1
fails "read-only" 2 "read-only" write "$drive" zlac8015d bus_voltage=1
fails "an unknown name lists the known ones" 2 "quick_stop" write "$drive" zlac8015d control_word=fly
fails "counts of a rescaled register are whole" 2 "whole counts" write "$drive" zlac8015d left_target_speed=1.5
fails "no number" 2 "'ten' is no number" write "$drive" zlac8015d left_max_current=ten
fails "no value" 2 "no REG=VALUE" write "$drive" zlac8015d left_max_current
fails "no register of that name" 2 "has no register 'speed'" read "$drive" zlac8015d speed
fails "no register at that address" 2 "has no register '0x3000'" read "$drive" zlac8015d 0x3000
fails "half a pair" 2 "second word of left_target_position" read "$drive" zlac8015d 0x208B
fails "a raw address beyond the end" 2 "is no ADDRESS" read "$drive" raw 0xFFFF:2
fails "too few raw values" 2 "1 values for 2 registers" write "$drive" raw 0x2088:2=5
fails "no such node" 2 "no node address of zlac8015d: 1 to 127" read "$drive" zlac8015d:128 bus_voltage
fails "no register at all" 2 "at least one register" read "$drive" zlac8015d
fails "no such format" 2 "--format takes" read "$drive" zlac8015d bus_voltage --format 7E1
fails "no such baud rate" 2 "--baud takes" read "$drive" zlac8015d bus_voltage --baud fast
fails "no such echo" 2 "--echo takes on or off" read "$drive" zlac8015d bus_voltage --echo maybe
fails "G4: an echo that stays out is said" 1 "the request did not come back as echo" \
    read "$drive" zlac8015d bus_voltage --echo on --retries 0
fails "an option without its value" 2 "--timeout needs a value" read "$drive" zlac8015d bus_voltage --timeout
run write "$drive" zlac8015d left_max_current=10 right_max_current=99
check "one wrong value and nothing is written" status_is 2
succeeds "nothing indeed" "left_max_current=12.5 A" read "$drive" zlac8015d left_max_current

# Writes that the drive or the line refuses

fails "an exception in the drive's words" 1 "refused, exception 2 (illegal data address)" read "$drive" raw 0x3000 --baud 115200
run write "$drive" zlac8015d left_max_current=10 control_word=3 right_max_current=10 --yes
check "a refused write is status 1" status_is 1
check "and says how many were done" err_has "refused, exception 3 (illegal data value); 1 of 3 written"
check "and shows them" out_is "left_max_current=10.0 A"
fails "no response from another node" 1 "bus_voltage: no response" \
    read "$drive" zlac8015d:9 bus_voltage --timeout 20 --retries 0
run write "$drive" zlac8015d:9 left_max_current=10 --timeout 20
check "a write without an answer is unknown" err_has "left_max_current: unknown, no response"
fails "no such port" 1 "No such file or directory" read /dev/no-such-port zlac8015d bus_voltage
fails "no serial device" 1 "no serial device" read /dev/null zlac8015d bus_voltage

# watch

run watch "$drive" zlac8015d left_actual_speed bus_voltage --count 3 --interval 10
check "watch: status 0" status_is 0
check "watch: a line a round" [ "$(grep -c '^[0-9.]* left_actual_speed=.* r/min, bus_voltage=24.00 V$' "$dir/out")" -eq 3 ]
check "watch: three rounds" [ "$(wc -l <"$dir/out")" -eq 3 ]
check "watch warns of the watchdog" err_has "watchdog"
"$tool" watch "$drive" zlac8015d bus_voltage --interval 10 >"$dir/watch.out" 2>/dev/null &
watcher=$!
check "watch goes on" until_true test -s "$dir/watch.out"
if [ -n "${ON_WINE:-}" ]; then
    echo "left out: a port has one user (Windows sees to that, wine does not)"
else
    run read "$drive" zlac8015d bus_voltage
    check "a port has one user" err_has "another program uses it"
fi
kill -INT "$watcher"
wait "$watcher"
status=$?
check "watch ends at an interrupt with status 0" status_is 0
fails "watch: no such interval" 2 "--interval takes" watch "$drive" zlac8015d bus_voltage --interval -1

# Unplugging, the end of sim, another drive

kill -USR1 "$sim"
check "SIGUSR1 pulls the plug" until_true grep -q unplugged "$dir/sim.err"
fails "no response" 1 "bus_voltage: no response" read "$drive" zlac8015d bus_voltage --timeout 20 --retries 0
kill -USR1 "$sim"
check "and puts it in again" until_true grep -q 'plugged in' "$dir/sim.err"
succeeds "and the drive answers" "bus_voltage=24.00 V" read "$drive" zlac8015d bus_voltage
stop_sim
check "sim ends at a signal with status 0" status_is 0
check "and takes its link away" [ ! -e "$drive" ]
start_sim zlac8015d --node 5 --baud 9600
succeeds "another node and baud rate" "node_address=5" read "$drive" zlac8015d:5 node_address --baud 9600
stop_sim
start_sim zlac8015d --faults noisy,lossy,doubled,cut --seed 7
reads=0
for i in 1 2 3 4 5 6 7 8 9 10; do
    [ "$("$tool" read "$drive" zlac8015d bus_voltage left_max_current --retries 9 2>/dev/null)" = "bus_voltage=24.00 V
left_max_current=30.0 A" ] && reads=$((reads + 1))
done
check "a bad line delays, but gives no wrong value" [ "$reads" -eq 10 ]
stop_sim
fails "sim: a rate that the drive does not have" 2 "--baud: zlac8015d has" sim zlac8015d --baud 4800
fails "sim: an unknown fault" 2 "--faults takes" sim zlac8015d --faults gremlins
fails "sim: no such node" 2 "--node takes" sim zlac8015d --node 0
: >"$dir/file"
fails "sim: a link over a file" 1 "File exists" sim zlac8015d --link "$dir/file"
