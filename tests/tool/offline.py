# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The commands that need no line: help, map, alarms, explain."""
import csv
import itertools
import re
import sys
import textwrap
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import standard_frames
from programs import Tool, play_tool, scene

ROOT = Path(__file__).resolve().parents[2]
DEVICES = "zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"
OLD = "address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit"
NEW = "flags,names,word_order,table,bits,offset,none,factor,byte_order"
HEADER = f"{OLD},{NEW}"
READS = "node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)"
SPEEDS = "node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min"
ENABLE = "node 1: write control_word (0x200E) = enable (0x0008)"
ENABLED = "node 1: response, control_word (0x200E) = enable (0x0008) written"


@scene()
def help_and_bad_commands(tool: Tool):
    tool.run("--help")
    commands = "map alarms explain sim read write watch backup restore header".split()
    tool.check("--help has every command", all(f"servobus {command} " in tool.last.out for command in commands))
    tool.status_is("--help is status 0", 0)
    version = re.search(r"^project\(servobus VERSION ([0-9.]*) ", (ROOT / "CMakeLists.txt").read_text(), re.M)
    tool.says("--version is the library's", "--version", f"servobus {version[1]}")
    for name, words, text in [
        ("no command", "", "no command"),
        ("an unknown command", "fly", "unknown command 'fly'"),
        ("an unknown option", "map zlac8015d --colour", "unknown option '--colour'"),
        ("an unknown device lists the known ones", "map zlac9000",
         "known: c630s, yako-closed-loop, yako-open-loop, zlac8015d"),
    ]:
        tool.fails(name, words, 2, text)


@scene()
def map_of_zlac8015d(tool: Tool):
    lines = tool.run("map zlac8015d").lines
    rows = lines[1:]
    tool.check("map: header", lines[0] == HEADER)
    tool.check("map: 116 registers", len(rows) == 116)
    tool.check("map: 23 columns in every row", all(line.count(",") == 22 for line in lines))
    tool.check("map: in address order", is_sorted(rows))
    for name, pattern in [
        ("map: a scaled row", r"0x2034,left_max_current,1,u16,rw,yes,,,,0,300,[0-9]*,0\.1,A,,,,holding,,,,,"),
        ("map: a pair", r"0x208A,left_target_position,2,i32,rw,no,,,,-2147483647,2147483647,0,1,pulse,motion,,,holding,,,,,"),
        ("map: a row without range and default", r"0x20A0,software_version,1,u16,ro,no,,,,,,,1,,,,,holding,,,,,"),
        ("map: codes", r"0x2007,shaft_at_power_on,.*,,,0=unlocked;1=locked,,holding,,,,,"),
        ("map: flags", r"0x2000,host_timeout,.*,ms,zero_by_name,,,holding,,,,,"),
        ("map: bits", r"0x2003,input_state,.*,,,b0=x0;b1=x1,,holding,,,,,"),
        ("map: fields", r"0x20A2,status_word,.*,0xC000:0x0000=left released;0xC000:0x4000=left locked;.*;b8=left running;"
         r".*;b0=right running,,holding,,,,,"),
        ("map: halves", r"0x20A4,motor_temperature,.*,degC,,halves,,holding,,,,,"),
    ]:
        tool.check(name, any(re.fullmatch(pattern, row) for row in rows), "")
    tool.fails("map takes one device", "map", 2, "map takes one DEVICE, and one REG at most")
    tool.fails("map takes one register", "map zlac8015d 0x2000 0x2001", 2, "one REG at most")
    tool.fails("--profile is for the whole map", "map zlac8015d 0x2000 --profile", 2, "--profile is for the whole map")
    tool.fails("--long is for the whole map", "map zlac8015d 0x2000 --long", 2, "--long is for the whole map")


def is_sorted(rows: list[str]) -> bool:
    addresses = [row.split(",")[0] for row in rows]
    return addresses == sorted(addresses)


@scene(
    ("yako-closed-loop", 204, "0x0019,pair_word_order,1,u16,rw,no,,,,0,1,0,1,,communication,0=high first;1=low first,,holding,,,,,",
     "0x0024,target_position,2,i32,rw,no,,,,-2147483648,2147483647,5000,1,pulse,motion,,selectable,holding,,,,,",
     "0x0031,homing_method,1,i16,rw,no,,,,-4,35,24,1,,,",
     "0x0062,position_segment_1_speed,1,u16,rw,yes,,,,0,3000,120,1,r/min,scaled_elsewhere,,"),
    ("yako-open-loop", 208, "0x0031,homing_method,1,u16,rw,no,,,,17,35,24,1,,,"),
    ("c630s", 463, "0x0200,mode_of_operation,1,u16,rw,yes,stopped,immediate,,0,6,1,1,",
     "0x0603,target_speed,1,i16,rw,yes,running,immediate,S,-6000,6000,200,1,r/min",
     "0x0B11,feedback_pulses,2,i32,ro,no,,,PST,,,,1,counts",
     "0x0C0D,eeprom_update,1,u16,rw,yes,running,immediate,PST,0,1,1,1,"),
)
def map_is(tool: Tool, device: str, count: int, *expected: str):
    lines = tool.run(f"map {device}").lines
    tool.check(f"map {device}: {count} registers", len(lines) == count + 1)
    tool.check(f"map {device}: 23 columns", all(line.count(",") == 22 for line in lines))
    tool.check(f"map {device}: in address order", is_sorted(lines[1:]))
    for row in expected:
        tool.check(f"map {device}: {row}", any(line.startswith(row) for line in lines), "")


@scene(*DEVICES)
def long_map_is(tool: Tool, device: str):
    """The map, and a column with a sentence in quotes; the words of a register begin with it."""
    short = tool.run(f"map {device}").lines
    lines = tool.run(f"map {device} --long").lines
    tool.check(f"map {device} --long: header", lines[0] == f"{OLD},description,{NEW}")
    rows = [re.fullmatch(r'(.*),"([A-Z][^"]*\.)"(,.*)', line) for line in lines[1:]]
    tool.check(f"map {device} --long: the rows of the map", [row and row[1] + row[3] for row in rows] == short[1:])
    for row in list(csv.DictReader(lines))[::40]:
        said = tool.run(f"map {device} {row['name']}")
        tool.is_equal(f"map {device} {row['name']}: name and sentence", said.lines[:2],
                      [row["name"], row["description"]])
        rest = dict(re.fullmatch(r"(\w*) +(.*)", line).groups() for line in said.lines[3:])
        tool.check(f"map {device} {row['name']}: address and type",
                   rest["address"].startswith(row["address"]) and rest["type"].startswith(row["type"]))
        for word in (row["address"], f"{row['address'][2:].lower()}h"):
            tool.is_equal(f"map {device} {word}", tool.run(f"map {device} {word}").out, said.out)


PROFILES = {
    "zlac8015d": """
        # file_format = 1
        # name = zlac8015d
        # lowest_address = 1
        # highest_address = 127
        # baud = 115200
        # character_format = 8N1
        # word_order = high
        # max_read = 125
        # max_write = 123
        # response_ms = 32
        # turnaround_ms = 10
        # gap_ms = 0
        # quarantine_ms = 100
        # read_retries = 2
        # leading_bytes = 4
        # corrupted_request = 0
        # acknowledge = 5
        # echoes_byte_count = no
        # writes_blocks_only = no
        # exception_1 = illegal function
        # exception_2 = illegal data address
        # exception_3 = illegal data value""",
    "c630s": """
        # file_format = 1
        # name = c630s
        # lowest_address = 1
        # highest_address = 247
        # baud = 57600
        # character_format = 8N2
        # word_order = selectable
        # word_order_register = 0x0C1A
        # eeprom_switch = 0x0C0D
        # max_read = 16
        # max_write = 16
        # response_ms = 100
        # turnaround_ms = 10
        # gap_ms = 0
        # quarantine_ms = 100
        # read_retries = 2
        # leading_bytes = 4
        # corrupted_request = 0
        # acknowledge = 5
        # echoes_byte_count = yes
        # writes_blocks_only = no
        # exception_1 = illegal command
        # exception_2 = illegal data address
        # exception_3 = illegal data
        # exception_4 = refused""",
}


@scene(*DEVICES)
def profile_is(tool: Tool, device: str):
    """In front of the map, which stays as it is."""
    alone = tool.run(f"map {device} --long").out
    shown = tool.run(f"map {device} --long --profile").out
    profile = shown.removesuffix(alone)
    tool.check(f"map {device}: no profile unasked", "#" not in alone.replace("drive's", ""))
    tool.check(f"map {device} --profile: then the map", shown.endswith(alone))
    tool.check(f"map {device} --profile: keys and values",
               all(re.fullmatch(r"# [a-z0-9_]+ = \S.*", line) for line in profile.splitlines()) and profile)
    tool.check(f"map {device} --profile: name", f"# name = {device}\n" in profile)
    if device in PROFILES:
        tool.is_equal(f"map {device} --profile", profile, textwrap.dedent(PROFILES[device]).lstrip("\n") + "\n")


@scene()
def documented_columns(tool: Tool):
    """The tool's README has each column and each key of a profile."""
    page = (ROOT / "examples/servobus/README.md").read_text("utf-8")
    page = page.split("\n## Columns of a map\n")[1].split("\n## ")[0]
    words = {word for row in re.findall(r"^\| (.*?) \|", page, re.M) for word in re.findall(r"`(\w+)`", row)}
    lines = [line for device in DEVICES for line in tool.run(f"map {device} --long --profile").lines]
    keys = {line.split()[1] for line in lines if line.startswith("#")}
    columns = set(next(line for line in lines if not line.startswith("#")).split(","))
    tool.is_equal("map: the columns and keys of the page", words,
                  columns | {key for key in keys if not key.startswith("exception_")} | {"exception_1"})


# What `map` prints below the sentence.
REGISTERS = {
    "zlac8015d left_max_current": """
        address    0x2034
        type       u16
        access     read and write
        range      0..300 (0.0..30.0 A)
        default    300 (30.0 A)
        unit       0.1 A
        written    the manual does not say when
        saved      by a command of its own""",
    "zlac8015d motor_temperature": """
        address    0x20A4
        type       i16
        access     read-only
        unit       degC
        values     high byte: left
                   low byte: right""",
    "zlac8015d host_timeout": """
        address    0x2000
        type       u16
        access     read and write
        range      0..32767 ms
        default    1000 ms
        unit       ms
        written    the manual does not say when
        saved      by a command of its own
        note       what 0 does is not documented""",
    "zlac8015d control_word": """
        address    0x200E
        type       u16
        access     read and write
        range      0..18
        default    0 (undefined)
        written    the manual does not say when
        note       acts when it is written
        values     0x00: undefined
                   0x05: quick stop
                   0x06: fault reset
                   0x07: stop
                   0x08: enable
                   0x10: start both
                   0x11: start left
                   0x12: start right""",
    "yako-closed-loop target_position": """
        address    0x0024 and 0x0025
        type       i32, two registers
        access     read and write
        range      -2147483648..2147483647 pulse
        default    5000 pulse
        unit       pulse
        written    the manual does not say when
        note       a write moves an enabled motor""",
    "yako-open-loop pair_word_order": """
        address    0x0019
        type       u16
        access     read and write
        range      0..1
        default    0 (high first)
        written    the manual does not say when
        note       a setting of the line
        values     0: high first
                   1: low first""",
    "c630s P02-00": """
        address    0x0200 (P02-00)
        type       u16
        access     read and write
        range      0..6
        default    1 (position)
        written    only while the motor is stopped
        effective  at once
        saved      by each write, which wears the EEPROM
        values     0: speed
                   1: position
                   2: torque
                   3: torque or speed
                   4: speed or position
                   5: torque or position
                   6: torque or speed or position""",
    "c630s feedback_pulses": """
        address    0x0B11 and 0x0B12 (P0B-17)
        type       i32, two registers
        access     read-only
        unit       counts
        modes      position, speed, torque""",
    "c630s target_speed": """
        address    0x0603 (P06-03)
        type       i16
        access     read and write
        range      -6000..6000 r/min
        default    200 r/min
        unit       r/min
        written    at any time
        effective  at once
        saved      by each write, which wears the EEPROM
        modes      speed
        note       a write moves an enabled motor""",
}


@scene()
def one_register(tool: Tool):
    for words, expected in REGISTERS.items():
        said = tool.run(f"map {words}").out.split("\n\n", 1)[-1]
        tool.is_equal(f"map {words}", said, textwrap.dedent(expected).lstrip("\n") + "\n")
    for name, words, text in [
        ("the second word of a pair", "map zlac8015d 208Bh", "208Bh is the second word of left_target_position"),
        ("no such register", "map zlac8015d 3000h", "zlac8015d has no register '3000h'"),
        ("no hexadecimal number", "map zlac8015d 20G0h", "zlac8015d has no register '20G0h'"),
        ("h alone", "map zlac8015d h", "zlac8015d has no register 'h'"),
        ("no parameter number", "map zlac8015d P02-00", "zlac8015d has no register 'P02-00'"),
        ("raw has no map", "map raw 0x2000", "unknown device 'raw'"),
    ]:
        tool.fails(f"map: {name}", words, 2, text)


@scene()
def shown_by_its_page(tool: Tool):
    """The register in the tool's README is as the tool prints it."""
    page = (ROOT / "examples/servobus/README.md").read_text("utf-8")
    words, shown = re.search(r"^    \$ servobus (map \w+ \S+)\n((?:    .*\n|\n)+?)    +\.\.\.\n", page, re.M).groups()
    shown = textwrap.dedent(shown)
    tool.is_equal("map: as its page shows it", shown, tool.run(words).out[:len(shown)])


ALARMS = "code class resettable name cause remedy reset".split()


@scene(
    ("c630s", 58, "Er.101,fault,no,parameter out of range,", "Er.A40,warning,yes,"),
    ("zlac8015d", 13, "0x0004,fault,unstated,overcurrent,", "0x2000,fault,unstated,speed command,"),
    ("yako-closed-loop", 5, "1,alarm,unstated,error 1,"),
    ("yako-open-loop", 5, "5,alarm,unstated,error 5,"),
)
def alarms(tool: Tool, device: str, count: int, *expected: str):
    lines = tool.run(f"alarms {device}").lines
    rows = list(csv.DictReader(lines))
    tool.check(f"alarms {device}: header", lines[0] == ",".join(ALARMS))
    tool.check(f"alarms {device}: {count}", len(rows) == count)
    tool.check(f"alarms {device}: every cell has text",
               all(list(row) == ALARMS and all(row.values()) for row in rows))
    for begin in expected:
        tool.check(f"alarms {device}: {begin}", any(line.startswith(begin) for line in lines), "")
    tool.check(f"alarms {device}: the first four columns have no quotes",
               all(line.split(",")[:4] == [row[name] for name in ALARMS[:4]] for line, row in zip(lines[1:], rows)))


@scene()
def alarms_in_detail(tool: Tool):
    rows = {row["code"]: row for row in csv.DictReader(tool.run("alarms c630s").lines)}
    tool.check("alarms: 43 faults", sum(row["class"] == "fault" for row in rows.values()) == 43)
    tool.is_equal("alarms: what to do after a failed homing", rows["Er.601"]["remedy"],
                  "Raise P05-35. Check that the home signal works. Move the home point, or change the search direction.")
    tool.is_equal("alarms: how a warning is reset", rows["Er.601"]["reset"], "Set P0D-01 to 1; the servo may stay on.")
    tool.fails("alarms takes one device", "alarms", 2, "alarms takes one DEVICE")
    tool.fails("alarms of an unknown device", "alarms c631s", 2, "unknown device 'c631s'")


def explain(tool: Tool, *frames: str, devices: str = "zlac8015d"):
    return tool.run(f"explain {devices}", stdin="".join(frame + "\n" for frame in frames))


@scene()
def logs_of_others(tool: Tool):
    """Lines of logs as people paste them: with words around the frame, and of Modbus TCP."""
    for line, said in [
        ("2024-08-29 20:58:01,016 DEBUG logging:103 SEND: 0x0 0x1 0x0 0x0 0x0 0x6 0x1 0x3 0x0 0xa 0x0 0x2",
         "node 1 (Modbus TCP, transaction 1): read unknown registers (0x000A..0x000B)"),
        ("[00][01][00][00][00][06][01][03][04][3A][00][01]",
         "node 1 (Modbus TCP, transaction 1): read unknown register (0x043A)"),
        ("<00><02><00><00><00><03><FF><83><02>",
         "node 255 (Modbus TCP, transaction 2): response, exception 2 (illegal data address) to function 03"),
        ("00 03 00 00 00 06 00 03 04 3A 00 01",
         "node 0 (Modbus TCP, transaction 3): read unknown register (0x043A)"),
        ("[16:40:36.035][D][modbus_bridge:695]: RTU send: 01 03 04 3A 00 01 A5 37  client_id=1",
         "node 1: read unknown register (0x043A)"),
        ("13:03:20.743 NRG: Modbus register 2, phase 0, rcvd 010404C32C9822EDD0, T 0, F 0, value -172.5943",
         "node 1: response, 2 words 0xC32C 0x9822"),
    ]:
        explain(tool, line, devices="raw")
        tool.out_is(f"explain: {line[:40]}", said)
    asks, says = "00 07 00 00 00 06 01 03 20 AB 00 02", "00 07 00 00 00 07 01 03 04 00 64 00 64"
    explain(tool, f"{asks} {says}")
    tool.out_is("explain: a request and its response of Modbus TCP in one line",
                f"bytes 1..12: {READS.replace('node 1', 'node 1 (Modbus TCP, transaction 7)')}",
                f"bytes 13..25: {SPEEDS.replace('node 1', 'node 1 (Modbus TCP, transaction 7)')}")
    tool.run("explain zlac8015d --hex", stdin=asks + "\n")
    tool.out_is("explain --hex: the bytes as they were", f"{asks}  {READS.replace('node 1', 'node 1 (Modbus TCP, transaction 7)')}")
    explain(tool, "what is 01 03 20 AB 00 02 BE 2C and more")
    tool.status_is("explain: a damaged frame among words is none", 1)


@scene()
def explained(tool: Tool):
    explain(tool, "> 01 03 20 AB 00 02 BE 2B", "< 01 03 04 00 64 00 64 BA 07", "", "# a comment", "0106200E0008E20F")
    tool.out_is("explain: names, values, both directions", READS, SPEEDS,
                f"{ENABLE} (request, or the response that echoes it)")
    tool.status_is("explain: status 0", 0)
    explain(tool, "01 06 20 0E 00 08 E2 0E", "01 06 20 0E 00 08 E2 0F")
    tool.status_is("explain: a wrong CRC is status 1", 1)
    tool.out_has("explain: and says what it should be", "wrong CRC, ends in E2 0E, should be E2 0F")
    tool.out_has("explain: the next frame is explained all the same", "enable")
    explain(tool, "> 01 02 00 00 00 04 79 C9", "< 01 82 02 C1 61")
    tool.is_equal("explain: a response to an invalid request belongs to it", tool.last.lines[-1],
                  "node 1: response, exception 2 (illegal data address) to read discrete inputs 0x0000..0x0003")
    explain(tool, "what is this")
    tool.status_is("explain: no hex is status 1", 1)
    tool.out_is("explain: and says why", "invalid: not a frame in hex")


@scene()
def explained_functions(tool: Tool):
    frames = [frame for frame, _ in standard_frames.explained()]
    words = [text for _, text in standard_frames.explained()]
    explain(tool, *frames)
    tool.out_is("explain: every function of the standard, and the bytes of what has no words", *words)
    tool.status_is("explain: and status 0", 0)
    tool.run("explain zlac8015d", stdin="".join(frames).replace(" ", "") + "\n")
    ends = list(itertools.accumulate(len(bytes.fromhex(frame)) for frame in frames))
    tool.out_is("explain: the same in one line without a gap, with the places of the frames",
                *[f"bytes {begin + 1}..{end}: {text}" for begin, end, text in zip([0] + ends, ends, words)])
    tool.status_is("explain: also status 0", 0)


@scene()
def explained_from_other_programs(tool: Tool):
    logged = [
        ("0x1 0x3 0x20 0xab 0x0 0x2 0xbe 0x2b # pymodbus", READS),
        ("01.03.20.AB.00.02.BE.2B (8)", READS),
        (">>> 01:03:20:AB:00:02:BE:2B", READS),
        ("<<< 01:03:04:00:64:00:64:BA:07", SPEEDS),
        ("[01][06][20][0E][00][08][E2][0F]", ENABLE),
        ("<01><06><20><0E><00><08><E2><0F>", ENABLED),
        ("<Buffer 01 03 20 ab 00 02 be 2b>", READS),
        ("Tx:000001-01 03 20 AB 00 02 BE 2B", READS),
        ("01-03-20-AB-00-02-BE-2B", READS),
    ]
    explain(tool, *[line for line, _ in logged])
    tool.out_is("explain: lines of other programs", *[words for _, words in logged])
    tool.status_is("explain: and status 0", 0)
    explain(tool, "Rx:000001-01 03 20 AB 00 02 BE 2B", "Rx:000002-01 06 20 0E 00 08 E2 0F",
            "Tx:000003-01 06 20 0E 00 08 E2 0F")
    tool.out_is("explain: a server's log, in which what is received are the requests", READS, ENABLE, ENABLED)
    explain(tool, "01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 07", "FF 00 01 03 20 AB 00 02 BE 2B 00")
    tool.out_is("explain: a request and a response in one line, noise around a frame", f"bytes 1..8: {READS}",
                f"bytes 9..17: {SPEEDS}",
                f"{READS} (noise before it: FF 00) (noise after it: 00)")
    tool.status_is("explain: which are valid", 0)
    explain(tool, "01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 08")
    tool.out_is("explain: a damaged frame after a valid one", f"bytes 1..8: {READS}",
                "bytes 9..17: invalid: no frame in 9 bytes: 01 03 04 00 64 00 64 BA 08")
    tool.status_is("explain: is status 1", 1)


# Lines as programs write them, one of each, and who does; each frame has a right CRC.
LOGGED = [
    ("0x1 0x3 0x0 0x0 0x0 0x2 0xc4 0xb", "pymodbus: request, node 1 reads 0000h..0001h"),
    ("01.03.00.00.00.02.C4.0B (8)", "ESPHome modbus write"),
    (">>> 01:03:00:00:00:02:C4:0B", "ESPHome uart debug: request"),
    ("<<< 01:03:04:00:01:00:02:2A:32", "ESPHome uart debug: response 1, 2"),
    ("[01][03][00][00][00][02][C4][0B]", "libmodbus, mbpoll -v: request"),
    ("<01><03><04><00><01><00><02><2A><32>", "libmodbus, mbpoll -v: response"),
    ("<Buffer 01 03 00 00 00 02 c4 0b>", "node"),
    ("Tx:000001-01 03 00 00 00 02 C4 0B", "Modbus Poll"),
    ("01-03-00-00-00-02-C4-0B", ".NET"),
    ("01 03 00 00 00 02 C4 0B 01 03 04 00 01 00 02 2A 32",
     "one read of /dev/ttyS0: request and response glued (epics-modules/modbus#39)"),
    ("FF 00 9C 03 04 00 ED 18 AA AC B0 00",
     "esphome/issues#3373: noise before and after a response of node 156"),
]


@scene()
def explained_logs(tool: Tool):
    asks = "node 1: read unknown registers (0x0000..0x0001)"
    answers = "node 1: response, unknown registers (0x0000..0x0001) = 0x0001 0x0002"
    noisy = ("node 156: response, 2 words 0x00ED 0x18AA (no response to the request before it: frame of another node)"
             " (noise before it: FF 00) (noise after it: 00)")
    expected = [asks, asks, asks, answers, asks, answers, asks, asks, asks, f"bytes 1..8: {asks}",
                f"bytes 9..17: {answers}", noisy]
    explain(tool, *[f"{line}    # {source}" for line, source in LOGGED], devices="raw")
    tool.out_is("explain: a line of each program, all together", *expected)
    tool.status_is("explain: which are valid", 0)
    for line, source in LOGGED:
        explain(tool, line, devices="raw")
        tool.status_is(f"explain: the line of {source}", 0)
        tool.check("explain: has no invalid frame", tool.last.out and "invalid" not in tool.last.out)


@scene()
def explained_with_places(tool: Tool):
    glued = "01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 07"
    tool.run("explain zlac8015d --hex", stdin=glued + " 12 34 56 78\n")
    tool.out_is("explain --hex: where each frame of a line stands", f"{glued[:23]}  (bytes 1..8)  {READS}",
                f"{glued[24:]}  (bytes 9..17)  {SPEEDS}",
                "12 34 56 78  (bytes 18..21)  invalid: no frame in 4 bytes: 12 34 56 78")
    tool.status_is("explain --hex: the rest is status 1", 1)


@scene()
def explained_by_device(tool: Tool):
    explain(tool, "> 01 03 20 AB 00 02 BE 2B", "> 02 03 0B 11 00 02 96 19", "> 03 03 20 AB 00 02 BF C9",
            devices="zlac8015d:1 c630s:2")
    tool.out_is("explain: several devices by their addresses", READS, "node 2: read feedback_pulses (0x0B11)",
                "node 3: read unknown registers (0x20AB..0x20AC)")
    tool.fails("explain: no address 0", "explain zlac8015d:0", 2, "'0' is no node address of zlac8015d")
    explain(tool, "> 01 03 0B 11 00 02 96 2A", "> 02 03 0B 11 00 02 96 19", devices="raw:1 c630s")
    tool.out_is("explain: one for all other addresses, and one without a map",
                "node 1: read unknown registers (0x0B11..0x0B12)", "node 2: read feedback_pulses (0x0B11)")
    tool.fails("explain: no device", "explain", 2, "explain takes DEVICE[:NODE]...")
    tool.run("explain zlac8015d --hex", stdin="< 0106200E0008E20F\n")
    repeats = re.search(r"^< 01 06 20 0E 00 08 E2 0F  node 1: response", tool.last.out, re.M)
    tool.check("explain --hex repeats the frame", repeats)
    explain(tool, "> 010300240002840000", "> 0103002400028400", "< 01030400001388F765", devices="yako-closed-loop")
    tool.out_has("explain says that a word order is assumed or unknown", "word order")


play_tool()
