# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: features of the YAKOTEC steppers and the C630S that the ZLAC8015D does not have: word orders,
# names of negative codes, parameter numbers, an EEPROM that every write wears.

check "sim yako-closed-loop starts" start_sim yako-closed-loop
succeeds "a negative code by its name" "homing_method=mechanical_stop_1 (0xFFFF)" \
    write "$drive" yako-closed-loop homing_method=mechanical_stop_1
succeeds "and read back" "homing_method=mechanical_stop_1 (0xFFFF)" read "$drive" yako-closed-loop homing_method
succeeds "the same as a number" "homing_method=mechanical_stop_4 (0xFFFC)" \
    write "$drive" yako-closed-loop homing_method=-4
fails "a number below the range" 2 "is outside -4 .. 35" write "$drive" yako-closed-loop homing_method=-5
succeeds "a name that begins with a digit" "rs485_format=8N1 (0x0000)" \
    write "$drive" yako-closed-loop rs485_format=8N1
succeeds "a pair, high word first" "home_offset=-70000 pulse" write "$drive" yako-closed-loop home_offset=-70000
succeeds "lies so in the drive" "0x0035=65534 (0xFFFE)
0x0036=61072 (0xEE90)" read "$drive" raw 0x35:2 --baud 115200
succeeds "a pair after the order was switched, low word first" "pair_word_order=low_first (0x0001)
home_offset=-70001 pulse" write "$drive" yako-closed-loop pair_word_order=low_first home_offset=-70001
succeeds "lies the other way" "0x0035=61071 (0xEE8F)
0x0036=65534 (0xFFFE)" read "$drive" raw 0x35:2 --baud 115200
succeeds "and is read so by the next command" "home_offset=-70001 pulse" read "$drive" yako-closed-loop home_offset
fails "an exception in this drive's words" 1 "homing_method: refused, exception 7 (value out of range)" \
    write "$drive" yako-closed-loop homing_method=15
fails "no word order, no pair" 1 "word order, pair_word_order (0x0019): no response; nothing was written" \
    write "$drive" yako-closed-loop:9 home_offset=1 --timeout 20 --retries 0
fails "a parameter number is the C630S's" 2 "has no register 'P0B-17'" read "$drive" yako-closed-loop P0B-17
stop_sim
check "sim yako-open-loop starts" start_sim yako-open-loop --node 3
succeeds "open loop has its own rows" "actual_node_address=3
homing_method=home_24 (0x0018)" read "$drive" yako-open-loop:3 actual_node_address homing_method
fails "and no code of the other" 2 "is none of negative_limit" \
    write "$drive" yako-open-loop:3 homing_method=mechanical_stop_1
stop_sim

check "sim c630s starts" start_sim c630s
succeeds "a register by its parameter number" "target_speed=200 r/min
pair_word_order=low_first (0x0001)" read "$drive" c630s P06-03 P0C-26
fails "not in small letters" 2 "a parameter number is written P0B-17" read "$drive" c630s p0b-17
fails "nor half a pair" 2 "P0B-18 is the second word of feedback_pulses" read "$drive" c630s P0B-18
succeeds "a pair, low word first" "gear_1_numerator=70000" write "$drive" c630s gear_1_numerator=70000
check "lies so in the drive" sh -c "'$tool' read '$drive' raw 0x0507:2 --baud 57600 | tr '\n' ' ' |
    grep -q '0x0507=4464 (0x1170) 0x0508=1 (0x0001)'"
succeeds "a parameter" "jog_speed=50 r/min" write "$drive" c630s jog_speed=50
check "its write wears the EEPROM and says so" err_has "jog_speed is kept in the EEPROM, which this write wears"
run write "$drive" c630s eeprom_update=off jog_speed=60
check "P0C-13 = 0 by the bus is done" status_is 0
check "and is worn itself" err_has "eeprom_update is kept in the EEPROM"
check "but what follows it is not" sh -c "! grep -q 'jog_speed is kept' '$dir/err'"
run write "$drive" c630s jog_speed=50
check "nor by another command" sh -c "! grep -q EEPROM '$dir/err'"
run write "$drive" c630s eeprom_update=on
check "and on again" status_is 0
stop_sim
