# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: the commands that need no line: help, map, alarms, explain.

# Help and bad commands

run --help
check "--help has every command" sh -c "for c in map alarms explain sim read write watch backup restore; do grep -q \"servobus \$c \" '$dir/out' || exit 1; done"
check "--help is status 0" status_is 0
succeeds "--version is the library's" \
    "servobus $(sed -n 's/^project(servobus VERSION \([0-9.]*\) .*/\1/p' "$parts/../../CMakeLists.txt")" --version
fails "no command" 2 "no command"
fails "an unknown command" 2 "unknown command 'fly'" fly
fails "an unknown option" 2 "unknown option '--colour'" map zlac8015d --colour
fails "an unknown device lists the known ones" 2 "known: zlac8015d, yako-closed-loop, yako-open-loop, c630s" map zlac9000

# map

run map zlac8015d
header='address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit'
check "map: header" [ "$(head -n 1 "$dir/out")" = "$header" ]
check "map: 116 registers" [ "$(wc -l <"$dir/out")" -eq 117 ]
check "map: 14 columns in every row" [ "$(awk -F, 'NF != 14' "$dir/out" | wc -l)" -eq 0 ]
check "map: in address order" sh -c "tail -n +2 '$dir/out' | cut -d, -f1 | sort -c"
check "map: a scaled row" grep -qx '0x2034,left_max_current,1,u16,rw,yes,,,,0,300,[0-9]*,0.1,A' "$dir/out"
check "map: a pair" grep -qx '0x208A,left_target_position,2,i32,rw,no,,,,-2147483647,2147483647,0,1,pulse' "$dir/out"
check "map: a row without range and default" grep -qx '0x20A0,software_version,1,u16,ro,no,,,,,,,1,' "$dir/out"
fails "map takes one device" 2 "map takes one DEVICE" map
# map_is DEVICE ROWS ROW...
map_is() {
    device=$1 rows=$2
    shift 2
    run map "$device"
    check "map $device: $rows registers" [ "$(wc -l <"$dir/out")" -eq $((rows + 1)) ]
    check "map $device: 14 columns" [ "$(awk -F, 'NF != 14' "$dir/out" | wc -l)" -eq 0 ]
    check "map $device: in address order" sh -c "tail -n +2 '$dir/out' | cut -d, -f1 | sort -c"
    for row in "$@"; do check "map $device: $row" grep -qxF "$row" "$dir/out"; done
}
map_is yako-closed-loop 204 \
    '0x0019,pair_word_order,1,u16,rw,no,,,,0,1,0,1,' \
    '0x0024,target_position,2,i32,rw,no,,,,-2147483648,2147483647,5000,1,pulse' \
    '0x0031,homing_method,1,i16,rw,no,,,,-4,35,24,1,' \
    '0x0062,position_segment_1_speed,1,u16,rw,yes,,,,0,3000,120,1,r/min'
map_is yako-open-loop 208 '0x0031,homing_method,1,u16,rw,no,,,,17,35,24,1,'
map_is c630s 463 \
    '0x0200,mode_of_operation,1,u16,rw,yes,stopped,immediate,,0,6,1,1,' \
    '0x0603,target_speed,1,i16,rw,yes,running,immediate,S,-6000,6000,200,1,r/min' \
    '0x0B11,feedback_pulses,2,i32,ro,no,,,PST,,,,1,counts' \
    '0x0C0D,eeprom_update,1,u16,rw,yes,running,immediate,PST,0,1,1,1,'

# alarms

run alarms c630s
check "alarms: header" [ "$(head -n 1 "$dir/out")" = "code,class,resettable,name" ]
check "alarms: 58" [ "$(wc -l <"$dir/out")" -eq 59 ]
check "alarms: 43 faults" [ "$(grep -c ',fault,' "$dir/out")" -eq 43 ]
check "alarms: a fault" grep -qx 'Er.101,fault,no,parameter out of range' "$dir/out"
check "alarms: a warning" grep -qx 'Er.A40,warning,yes,.*' "$dir/out"
fails "alarms of a drive without a table" 2 "zlac8015d has no table of alarms" alarms zlac8015d
fails "alarms takes one device" 2 "alarms takes one DEVICE" alarms

# explain

frames() { printf '%s\n' "$@" | "$tool" explain zlac8015d >"$dir/out" 2>"$dir/err"; status=$?; }
frames '> 01 03 20 AB 00 02 BE 2B' '< 01 03 04 00 64 00 64 BA 07' '' '# a comment' '0106200E0008E20F'
check "explain: names, values, both directions" out_is "node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)
node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min
node 1: write control_word (0x200E) = enable (0x0008) (request, or the response that echoes it)"
check "explain: status 0" status_is 0
frames '01 06 20 0E 00 08 E2 0E' '01 06 20 0E 00 08 E2 0F'
check "explain: a wrong CRC is status 1" status_is 1
check "explain: and says what it should be" grep -q 'wrong CRC, ends in E2 0E, should be E2 0F' "$dir/out"
check "explain: the next frame is explained all the same" grep -q 'enable' "$dir/out"
frames '> 01 02 00 00 00 04 79 C9' '< 01 82 02 C1 61'
check "explain: a response to an invalid request belongs to it" [ "$(tail -n 1 "$dir/out")" = \
    "node 1: response, exception 2 (illegal data address) to function 02" ]
frames 'what is this'
check "explain: no hex is status 1" status_is 1
check "explain: and says why" [ "$(cat "$dir/out")" = "invalid: not a frame in hex" ]
frames '01 05 00 AC FF 00 4C 1B' '< 01 01 02 CD 01 2C AC' '11 11 CD EC'
check "explain: valid frames of other functions, with their bytes" out_is "node 1: valid frame of function 05 (write single coil), data 00 AC FF 00
node 1: valid frame of function 01 (read coils), data 02 CD 01
node 17: valid frame of function 11h (report server ID), no data"
check "explain: which is status 0" status_is 0
# As other programs log them.
frames '0x1 0x3 0x20 0xab 0x0 0x2 0xbe 0x2b # pymodbus' '01.03.20.AB.00.02.BE.2B (8)' '>>> 01:03:20:AB:00:02:BE:2B' \
    '<<< 01:03:04:00:64:00:64:BA:07' '[01][06][20][0E][00][08][E2][0F]' '<01><06><20><0E><00><08><E2><0F>' \
    '<Buffer 01 03 20 ab 00 02 be 2b>' 'Tx:000001-01 03 20 AB 00 02 BE 2B' '01-03-20-AB-00-02-BE-2B'
reads="node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)"
speeds="node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min"
check "explain: lines of other programs" out_is "$reads
$reads
$reads
$speeds
node 1: write control_word (0x200E) = enable (0x0008)
node 1: response, control_word (0x200E) = enable (0x0008) written
$reads
$reads
$reads"
check "explain: and status 0" status_is 0
frames 'Rx:000001-01 03 20 AB 00 02 BE 2B' 'Rx:000002-01 06 20 0E 00 08 E2 0F' 'Tx:000003-01 06 20 0E 00 08 E2 0F'
check "explain: a server's log, in which what is received are the requests" out_is "$reads
node 1: write control_word (0x200E) = enable (0x0008)
node 1: response, control_word (0x200E) = enable (0x0008) written"
frames '01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 07' 'FF 00 01 03 20 AB 00 02 BE 2B 00'
check "explain: a request and a response in one line, noise around a frame" out_is "$reads
$speeds
$reads (noise before it: FF 00) (noise after it: 00)"
check "explain: which are valid" status_is 0
frames '01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 08'
check "explain: a damaged frame after a valid one" out_is "$reads
invalid: no frame in 9 bytes: 01 03 04 00 64 00 64 BA 08"
check "explain: is status 1" status_is 1
printf '%s\n' '> 01 03 20 AB 00 02 BE 2B' '> 02 03 0B 11 00 02 96 19' '> 03 03 20 AB 00 02 BF C9' |
    "$tool" explain zlac8015d:1 c630s:2 >"$dir/out" 2>"$dir/err"
check "explain: several devices by their addresses" out_is "node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)
node 2: read feedback_pulses (0x0B11)
node 3: read unknown registers (0x20AB..0x20AC)"
fails "explain: no address 0" 2 "'0' is no node address of zlac8015d" explain zlac8015d:0
printf '%s\n' '> 01 03 0B 11 00 02 96 2A' '> 02 03 0B 11 00 02 96 19' |
    "$tool" explain raw:1 c630s >"$dir/out" 2>"$dir/err"
check "explain: one for all other addresses, and one without a map" out_is "node 1: read unknown registers (0x0B11..0x0B12)
node 2: read feedback_pulses (0x0B11)"
fails "explain: no device" 2 "explain takes DEVICE[:NODE]..." explain
printf '< 0106200E0008E20F\n' | "$tool" explain zlac8015d --hex >"$dir/out" 2>"$dir/err"
check "explain --hex repeats the frame" grep -q '^< 01 06 20 0E 00 08 E2 0F  node 1: response' "$dir/out"
printf '> 010300240002840000\n> 0103002400028400\n< 01030400001388F765\n' | "$tool" explain yako-closed-loop >"$dir/out" 2>"$dir/err"
check "explain says that a word order is assumed or unknown" grep -q 'word order' "$dir/out"
