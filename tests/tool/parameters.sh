# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: backup and restore, a round trip on each drive.

differs_by() { [ "$(diff "$1" "$2" | grep -c '^> [a-z]')" -eq "$3" ]; } # the line of the CRC matches too and is counted
no_drafts() { [ "$(find "$dir" -name '*.part*' | wc -l)" -eq 0 ]; }

# round_trip DEVICE ROWS WEAR REG=VALUE...: saves, changes, shows and restores. WEAR: the reported cost in EEPROM
# writes.
round_trip() {
    device=$1 rows=$2 wear=$3
    shift 3
    file=$dir/$device.backup
    run backup "$drive" "$device" "$file"
    check "$device: backup" status_is 0
    check "$device: backup shows how far it is" err_has "reading: $rows of $rows"
    check "$device: $rows rows" [ "$(grep -c '^[a-z0-9_]*=[-0-9?]* #' "$file")" -eq "$rows" ]
    check "$device: the header says so" \
        [ "$(head -n 1 "$file")" = "servobus-backup format=1 device=$device rows=$rows" ]
    check "$device: no draft is left" no_drafts
    run write "$drive" "$device" "$@"
    check "$device: changes" status_is 0
    "$tool" backup "$drive" "$device" >"$dir/changed" 2>/dev/null
    check "$device: $# rows differ, and the checksum" differs_by "$file" "$dir/changed" $(($# + 1))
    run restore "$drive" "$device" "$file" --dry-run
    check "$device: --dry-run shows them" [ "$(grep -c ' -> ' "$dir/out")" -eq $# ]
    "$tool" backup "$drive" "$device" 2>/dev/null | cmp -s - "$dir/changed"
    check "$device: and changes nothing" [ $? -eq 0 ]
    run restore "$drive" "$device" "$file" --yes
    check "$device: restore" status_is 0
    check "$device: restore says what it costs" err_has "writes into the EEPROM: $wear"
    check "$device: restore lists what it wrote" [ "$(wc -l <"$dir/out")" -eq $# ]
    "$tool" backup "$drive" "$device" 2>/dev/null | cmp -s - "$file"
    check "$device: the drive is as it was" [ $? -eq 0 ]
    run restore "$drive" "$device" "$file" --yes
    check "$device: again there is nothing to do" err_has "0 of "
    check "$device: and nothing is written" out_is ""
}
# refused_at_work NAME WORDS: the drive is enabled, and $file differs from it
refused_at_work() {
    "$tool" backup "$drive" "$device" >"$dir/changed" 2>/dev/null
    fails "$1" 1 "$2" restore "$drive" "$device" "$file"
    "$tool" backup "$drive" "$device" 2>/dev/null | cmp -s - "$dir/changed"
    check "S7: and nothing is written" [ $? -eq 0 ]
    run restore "$drive" "$device" "$file" --dry-run
    check "but --dry-run looks" status_is 0
    check "and says that it would be refused" err_has "without --dry-run it is refused"
}

start_sim zlac8015d
round_trip zlac8015d 88 "none; --save" left_max_current=12.5 right_speed_kp=77 input_polarity=x1
run write "$drive" zlac8015d left_max_current=12.5 node_address=5
run restore "$drive" zlac8015d "$file" --yes --save
check "zlac8015d: --save saves once" err_has "none, but one save at the end"
succeeds "S7: the line's settings stay" "node_address=5
left_max_current=30.0 A" read "$drive" zlac8015d node_address left_max_current
run write "$drive" zlac8015d node_address=1 left_max_current=5 mode_of_operation=velocity control_word=enable --yes
refused_at_work "S7: zlac8015d: refused while enabled" "a shaft is held, the drive is enabled"
run write "$drive" zlac8015d left_target_speed=20 --yes
fails "S7: zlac8015d: refused while it turns" 1 "a wheel turns" restore "$drive" zlac8015d "$file" --yes
run write "$drive" zlac8015d left_target_speed=0 control_word=stop
at_rest() { "$tool" read "$drive" zlac8015d status_word | grep -q 'left_released+right_released (0x0000)'; }
check "zlac8015d: at rest again" until_true at_rest
run write "$drive" zlac8015d mode_of_operation=torque --yes
fails "S7: zlac8015d: refused in torque mode, where the status may not tell that it is enabled" 1 "in torque mode" \
    restore "$drive" zlac8015d "$file" --yes
run write "$drive" zlac8015d mode_of_operation=velocity --yes
run restore "$drive" zlac8015d "$file" --yes --save
check "zlac8015d: a save clears the mode first, which would be kept perhaps" status_is 0
succeeds "and it is cleared" "mode_of_operation=undefined (0x0000)" read "$drive" zlac8015d mode_of_operation
fails "S3: a watchdog time of 0 is not written" 2 "host_timeout: what 0 does is not documented; only \"write PORT raw" \
    write "$drive" zlac8015d host_timeout=0 --yes
fails "S3: nor by its address" 2 "what 0 does is not documented" write "$drive" zlac8015d 0x2000=0x0 --yes
run write "$drive" raw 0x2000=0 --yes --baud 115200
check "S3: but as a raw address, by name" status_is 0
succeeds "S3: it is shown" "host_timeout=0 ms" read "$drive" zlac8015d host_timeout
run backup "$drive" zlac8015d "$dir/zero"
check "S3: and backed up" grep -q '^host_timeout=0 # 0 ms' "$dir/zero"
check "with no register left out" err_has "reading: 88 of 88"
run restore "$drive" zlac8015d "$dir/zero" --yes
check "S3: a restore has nothing to do there" status_is 0
run write "$drive" zlac8015d host_timeout=500
run restore "$drive" zlac8015d "$dir/zero" --yes
check "S3: a restore of 0 is refused" status_is 1
check "and says why" err_has "refused, nothing was written: host_timeout: what 0 does"
run restore "$drive" zlac8015d "$dir/zero" --dry-run
check "S3: and --dry-run says so" err_has "without --dry-run it is refused: host_timeout"
succeeds "S3: and nothing was written" "host_timeout=500 ms" read "$drive" zlac8015d host_timeout
run write "$drive" zlac8015d host_timeout=1000
run write "$drive" zlac8015d mode_of_operation=undefined left_max_current=5
run restore "$drive" zlac8015d "$file" --yes
check "zlac8015d: and restored" out_is "left_max_current=30.0 A"
fails "zlac8015d: no response" 1 "the drive's state: no response; nothing was written" \
    restore "$drive" zlac8015d:7 "$file" --timeout 20 --retries 0
fails "a backup of a node that does not respond" 1 "no response" \
    backup "$drive" zlac8015d:7 "$dir/none" --timeout 20 --retries 0
check "makes no file" [ ! -e "$dir/none" ]
run backup "$drive" zlac8015d "$dir/none/file"
check "a backup into nowhere is status 1" status_is 1
check "and says so" err_has "cannot write $dir/none/file: No such file"
stop_sim

# An interruption, at a baud rate slow enough for it. The file differs in every register that may be changed.
start_sim zlac8015d --baud 9600
file=$dir/slow
"$tool" backup "$drive" zlac8015d "$dir/before" --baud 9600 2>/dev/null
other_values zlac8015d "$dir/before" >"$file"
fix_checksum zlac8015d "$file"
"$tool" restore "$drive" zlac8015d "$file" --baud 9600 --yes >"$dir/out" 2>"$dir/err" </dev/null &
restorer=$!
check "a restore is under way" until_true test -s "$dir/out"
kill -INT "$restorer"
wait "$restorer"
status=$?
check "an interrupted restore is status 1" status_is 1
check "and says where it stopped" grep -q 'interrupted; [0-9]* of [0-9]* written, not: ' "$dir/err"
written=$(sed -n 's/.*interrupted; \([0-9]*\) of.*/\1/p' "$dir/err")
check "as many as it has listed" [ "$written" = "$(wc -l <"$dir/out")" ]
run restore "$drive" zlac8015d "$dir/before" --baud 9600 --dry-run
check "and as the drive has" [ "$written" = "$(wc -l <"$dir/out")" ]
stop_sim

# A line that loses frames: a write without a response ends the run, and the next run continues from there.
start_sim zlac8015d --faults lossy,noisy,doubled --seed 3
"$tool" backup "$drive" zlac8015d "$dir/before" --retries 9 2>/dev/null
other_values zlac8015d "$dir/before" >"$file"
fix_checksum zlac8015d "$file"
runs=0
status=1
while [ "$status" -ne 0 ] && [ "$runs" -lt 40 ]; do
    run restore "$drive" zlac8015d "$file" --retries 9 --timeout 50 --yes
    [ "$status" -ne 0 ] && cat "$dir/err" >>"$dir/lost"
    runs=$((runs + 1))
done
check "a bad line: done at last" status_is 0
check "not in one run" [ "$runs" -gt 1 ]
check "and said what is uncertain" grep -q ': unknown, .*; [0-9]* of [0-9]* written, perhaps [a-z_0-9]*' "$dir/lost"
run restore "$drive" zlac8015d "$file" --retries 9 --dry-run
check "and as it should be" out_is ""
stop_sim

for device in yako-closed-loop yako-open-loop; do
    start_sim $device
    rows=191
    [ $device = yako-open-loop ] && rows=195
    run write "$drive" $device auxiliary_command=release --yes
    round_trip $device $rows "none; --save" acceleration_time=250 home_offset=-70000 position_segment_3_speed=99
    run write "$drive" $device auxiliary_command=enable acceleration_time=250 --yes
    refused_at_work "S7: $device: refused while enabled" "the motor is enabled"
    fails "$device: --part is the C630S's" 2 "--part" restore "$drive" $device "$file" --part
    stop_sim
done

start_sim c630s
round_trip c630s 394 3 jog_speed=50 gear_1_numerator=70000 do1_function=warning
check "c630s: and nothing more" grep -qx 'servobus: writes into the EEPROM: 0' "$dir/err"
run write "$drive" c630s jog_speed=50 eeprom_update=off
run restore "$drive" c630s "$file" --dry-run
check "c630s: none while P0C-13 is 0" err_has "writes into the EEPROM: none, since eeprom_update (0x0C0D) is 0"
fails "6.4.1: c630s: a function that another terminal has is not written" 1 \
    "di1_function (0x0302) has the function that virtual_input_1_function (0x1700) is to get" \
    write "$drive" c630s jog_speed=60 virtual_input_1_function=servo_on --yes
succeeds "c630s: nor anything else of that command" "jog_speed=50 r/min" read "$drive" c630s jog_speed
fails "c630s: nor by its address" 1 "refused, nothing was written: di7_function (0x030E) has" \
    write "$drive" c630s 0x0302=31 --yes
succeeds "c630s: it is once the other one has lost it" "di7_function=none (0x0000)
di4_function=home_switch (0x001F)
di4_function=home_switch (0x001F)" write "$drive" c630s di7_function=none di4_function=home_switch di4_function=home_switch
run restore "$drive" c630s "$file" --yes # DI4 and DI7 as before: DI4 first loses the function that DI7 gets
check "c630s: a restore moves functions between terminals" status_is 0
check "c630s: the one loses it before the other gets it" \
    [ "$(grep _function "$dir/out" | tr '\n' ' ')" = \
    "di4_function=none (0x0000) di4_function=alarm_reset (0x0002) di7_function=home_switch (0x001F) " ]
sed 's/^di1_function=.*/di1_function=31 #/' "$file" >"$dir/twice"
fix_checksum c630s "$dir/twice"
run restore "$drive" c630s "$dir/twice" --yes
check "c630s: a file that gives two terminals one function is refused" status_is 1
check "c630s: and says which" \
    err_has "refused, nothing was written: di7_function (0x030E) has the function that di1_function (0x0302)"
run write "$drive" c630s di1_function=none eeprom_update=on virtual_inputs_enable=on \
    virtual_input_1_function=servo_on virtual_input_levels=1 --yes
refused_at_work "S7: c630s: refused while enabled" "virtual input 1 enables the servo"
run write "$drive" c630s virtual_input_levels=0
"$tool" backup "$drive" c630s "$dir/wired" 2>/dev/null
run write "$drive" c630s virtual_input_1_function=none virtual_input_levels=1 --yes
run restore "$drive" c630s "$dir/wired" --yes
check "S7: c630s: a terminal that enables it ends a restore" status_is 1
check "and it says after which register" \
    err_has "stopped after virtual_input_1_function: virtual input 1 enables the servo"
run write "$drive" c630s virtual_input_levels=0
run write "$drive" c630s virtual_input_1_function=servo_on virtual_inputs_at_power_on=1 --yes
refused_at_work "S7: c630s: refused where a virtual input enables it at power-on" \
    "virtual input 1 enables the servo at power-on"
run write "$drive" c630s virtual_inputs_at_power_on=0 power_on_functions_1_to_16=1 --yes
refused_at_work "S7: c630s: refused where P03-00 enables it" "power_on_functions_1_to_16 enables the servo"
run write "$drive" c630s virtual_input_1_function=none power_on_functions_1_to_16=0 --yes
fails "c630s: it has no command to save" 2 "--save: c630s has no command to save" \
    restore "$drive" c630s "$file" --save
# The functions of terminals stay unchanged, since a number higher by one would be the function of another terminal.
other_values c630s "$file" | awk -F= 'NR == FNR { held[$1] = $0; next }
    $1 ~ /^(di|do|virtual_input_)[0-9]+_function$/ { print held[$1]; next }
    { print }' "$file" - >"$dir/many"
fix_checksum c630s "$dir/many"
run restore "$drive" c630s "$dir/many" --yes
check "c630s: more than 200 are refused" status_is 1
check "c630s: and why" err_has "more than 200 raise an alarm of the drive (Er.942); --part writes the first of them"
run restore "$drive" c630s "$dir/many" --part --dry-run
check "c630s: --part takes 200" [ "$(grep -c ' -> ' "$dir/out")" -ge 200 ]
check "c630s: and says so" grep -qx 'servobus: writes into the EEPROM: 200' "$dir/err"
# The same with the registers that affect neither terminals nor modes, on a drive that has not stored anything yet.
stop_sim
start_sim c630s
awk -F= 'NR == FNR { other[$1] = $0; next }
    $1 ~ /segment|notch|_gain|_time|_width|_depth|_threshold|_frequency|_limit|filter|_delay|offset|^virtual_output/ &&
        $1 in other { print other[$1]; next }
    { print }' "$dir/many" "$file" >"$dir/most"
fix_checksum c630s "$dir/most"
run restore "$drive" c630s "$dir/most" --part --yes
check "c630s: a part is done" status_is 0
check "c630s: which is 200" [ "$(wc -l <"$dir/out")" -eq 200 ]
run restore "$drive" c630s "$dir/most" --part --yes
check "c630s: the other part too" status_is 0
run restore "$drive" c630s "$dir/most" --yes
check "c630s: and no more" err_has "0 of "
