# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Features of the YAKOTEC steppers and the C630S that the ZLAC8015D does not have.

Word orders, names of negative codes, parameter numbers, an EEPROM that every write wears.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene


@scene()
def closed_loop(tool: Tool):
    write, read = "write drive yako-closed-loop", "read drive yako-closed-loop"
    raw = "read drive raw 0x35:2 --baud 115200"
    with tool.simulated("yako-closed-loop", named="sim yako-closed-loop starts"):
        for name, words, *lines in [
            ("a negative code by its name", f"{write} homing_method=mechanical_stop_1",
             "homing_method=mechanical_stop_1 (0xFFFF)"),
            ("and read back", f"{read} homing_method", "homing_method=mechanical_stop_1 (0xFFFF)"),
            ("the same as a number", f"{write} homing_method=-4", "homing_method=mechanical_stop_4 (0xFFFC)"),
        ]:
            tool.says(name, words, *lines)
        tool.fails("a number below the range", f"{write} homing_method=-5", 2, "is outside -4 .. 35")
        for name, words, *lines in [
            ("a name that begins with a digit", f"{write} rs485_format=8N1", "rs485_format=8N1 (0x0000)"),
            ("a pair, high word first", f"{write} home_offset=-70000", "home_offset=-70000 pulse"),
            ("lies so in the drive", raw, "0x0035=65534 (0xFFFE)", "0x0036=61072 (0xEE90)"),
            ("a pair after the order was switched, low word first",
             f"{write} pair_word_order=low_first home_offset=-70001", "pair_word_order=low_first (0x0001)",
             "home_offset=-70001 pulse"),
            ("lies the other way", raw, "0x0035=61071 (0xEE8F)", "0x0036=65534 (0xFFFE)"),
            ("and is read so by the next command", f"{read} home_offset", "home_offset=-70001 pulse"),
        ]:
            tool.says(name, words, *lines)
        for name, words, status, text in [
            ("an exception in this drive's words", f"{write} homing_method=15", 1,
             "homing_method: refused, exception 7 (value out of range)"),
            ("and the codes that it takes", f"{write} homing_method=15", 1, "; it takes -1 mechanical_stop_1, "),
            ("no word order, no pair", f"{write}:9 home_offset=1 --timeout 20 --retries 0", 1,
             "word order, pair_word_order (0x0019): no response; nothing was written"),
            ("a parameter number is the C630S's", f"{read} P0B-17", 2, "has no register 'P0B-17'"),
        ]:
            tool.fails(name, words, status, text)


@scene()
def open_loop(tool: Tool):
    with tool.simulated("yako-open-loop --node 3", named="sim yako-open-loop starts"):
        tool.says("open loop has its own rows", "read drive yako-open-loop:3 actual_node_address homing_method",
                  "actual_node_address=3", "homing_method=home_24 (0x0018)")
        tool.fails("and no code of the other", "write drive yako-open-loop:3 homing_method=mechanical_stop_1", 2,
                   "is none of 17 negative_limit")


@scene()
def c630s(tool: Tool):
    write, read = "write drive c630s", "read drive c630s"
    with tool.simulated("c630s", named="sim c630s starts"):
        tool.says("a register by its parameter number", f"{read} P06-03 P0C-26", "target_speed=200 r/min",
                  "pair_word_order=low_first (0x0001)")
        tool.fails("not in small letters", f"{read} p0b-17", 2, "a parameter number is written P0B-17")
        tool.fails("nor half a pair", f"{read} P0B-18", 2, "P0B-18 is the second word of feedback_pulses")
        tool.says("a pair, low word first", f"{write} gear_1_numerator=70000", "gear_1_numerator=70000")
        tool.says("lies so in the drive", "read drive raw 0x0507:2 --baud 57600", "0x0507=4464 (0x1170)",
                  "0x0508=1 (0x0001)")
        tool.says("a parameter", f"{write} jog_speed=50", "jog_speed=50 r/min")
        tool.err_has(
            "its write wears the EEPROM and says so", "jog_speed is kept in the EEPROM, which this write wears"
        )
        tool.exits("P0C-13 = 0 by the bus is done", f"{write} eeprom_update=off jog_speed=60", 0)
        tool.err_has("and says what follows from it",
                     "warning: after eeprom_update=off, what is written is lost with the power")
        tool.err_lacks("and nothing of itself", "eeprom_update is ")
        tool.err_lacks("but what follows it is not", "jog_speed is kept")
        tool.run(f"{write} jog_speed=50")
        tool.err_lacks("nor by another command", "EEPROM")
        tool.exits("and on again", f"{write} eeprom_update=on", 0)
        tool.err_has("and says what follows from it",
                     "warning: after eeprom_update=on, each write of a saved register wears the EEPROM")
        tool.err_lacks("and nothing of itself", "eeprom_update is ")


play_tool()
