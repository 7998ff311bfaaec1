# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Devices from files on a line: every command that takes a device, and what it cannot know of them."""
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from programs import Tool, play_tool, scene, until
from standard_frames import framed

METER = """# name = meter
# baud = 19200
# highest_address = 32
# exception_2 = no such value
address,name,type,access,scale,unit,min,max,default,flags,names,word_order
0x10,voltage,u16,ro,0.1,V,,,,,,
0x20,energy,u32,ro,,,,,,,,
0x22,balance,i32,ro,,,,,,,,low
0x30,ratio,u16,rw,0.01,times,1,1000,100,,,
0x31,mode,i16,rw,,,-1,2,0,,-1=off;0=once;2=for ever,
0x32,clear,u16,wo,,,,,,trigger,1=clear,
0x33,node,u16,rw,,,1,32,1,communication,,
0x34,span,i32,rw,,,-100000,100000,0,,,low
0x36,offset,i16,rw,,,,,,saved_on_write,,
0x3E,relays,u16,rw,,,,,,,b0=first;b1=second;0x00C0:0x0040=locked,
0x1FF,beyond,u16,ro,,,,,,,,
"""
WAIT = "--timeout 2000"


def filled() -> Device:
    device = Device()
    device.holding[0x10] = 2305
    device.holding[0x20:0x24] = [1, 2, 0xFFFF, 0xFFFF]
    device.holding[0x30:0x34] = [100, 0xFFFF, 0, 1]
    device.holding[0x34:0x36] = [5, 0]
    return device


def writes_of(device: Device) -> list[str]:
    return [pdu.hex() for pdu in device.requests if pdu[0] > 4]


@scene()
def meter(tool: Tool):
    tool.write("meter.csv", METER)
    device = filled()
    with on_terminal(device, node=3) as port:
        tool.says("read", f"read {port} meter.csv:3 voltage energy balance 0x30 mode {WAIT}", "voltage=230.5 V",
                  "energy=65538", "balance=-1", "ratio=1.00 times", "mode=off (0xFFFF)")
        tool.run(f"read {port} ./meter.csv:3 voltage mode --json {WAIT}")
        tool.out_has("as JSON", '"registers":{"voltage":{"value":230.5,"unit":"V"},"mode":{"value":-1,"text":"off"}}')
        tool.run(f"watch {port} {tool.folder}/meter.csv:3 voltage --csv --count 2 --interval 1 {WAIT}")
        tool.check("watch, by a path from the root", [line.split(",")[-1] for line in tool.last.lines] ==
                   ["voltage (V)", "230.5", "230.5"])
        tool.fails("an exception in the file's words", f"read {port} meter.csv:3 beyond {WAIT}", 1,
                   "beyond: refused, exception 2 (no such value)")
        tool.fails("a write-only register", f"read {port} meter.csv:3 clear", 2, "this register is write-only")
        tool.fails("the second word of a pair", f"read {port} meter.csv:3 0x35", 2, "0x35 is the second word of span")
        device.requests.clear()
        tool.says("write", f"write {port} meter.csv:3 ratio=2.5 mode=for_ever span=-2 relays=second+locked {WAIT}",
                  "ratio=2.50 times", "mode=for_ever (0x0002)", "span=-2", "relays=second+locked (0x0042)")
        tool.is_equal("a pair with its own word order", writes_of(device),
                      ["06003000fa", "0600310002", "1000340002" + "04fffeffff", "06003e0042"])
        device.requests.clear()
        for name, words, text in [
            ("a value out of range", "ratio=10.01", "is outside 0.01 times .. 10.00 times"),
            ("a value between counts", "ratio=2.555", "no whole number of counts"),
            ("no code", "mode=x", "is none of -1 off, 0 once, 2 for_ever"),
            ("a read-only register", "voltage=1", "this register is read-only"),
        ]:
            tool.fails(name, f"write {port} meter.csv:3 {words}", 2, text)
        tool.run(f"write {port} meter.csv:3 offset=-5 {WAIT}")
        tool.err_has("a register that each write wears", "offset is kept in the EEPROM, which this write wears")
        tool.is_equal("is written, and no switch is read", writes_of(device), ["060036fffb"])
        tool.check("and no switch is read", all(pdu[:3] != b"\3\0\0" for pdu in device.requests))


PLANT = """# word_order = low
address,name,table,type,access,unit,names,flags,description
12,pump,coil,bool,rw,,,motion,"Runs the pump."
13,valve,coil,,rw,,0=shut;1=open,,"Opens the valve."
4,level_high,discrete,,,,,,"The tank is full."
5,door,discrete,bool,ro,,0=closed;1=open,,"The door."
0x30,level,input,u16,ro,mm,,,"Of the tank."
0x31,volume,input,u32,ro,,,,"Of the tank."
0x30,setpoint,holding,,rw,mm,,,"Of the level."
"""


@scene()
def all_tables(tool: Tool):
    """Each table by its own functions; a plain address is that of a holding register."""
    tool.write("plant.csv", PLANT)
    device = Device()
    device.coils[12] = True
    device.holding[0x30] = 7
    names = "pump valve level_high door level volume setpoint"
    shown = ["pump=on", "valve=shut (0x0000)", "level_high=off", "door=closed (0x0000)", "level=4144 mm",
             f"volume={0x10321031}", "setpoint=7 mm"]
    with on_terminal(device) as port:
        tool.says("read", f"read {port} plant.csv {names} {WAIT}", *shown)
        tool.is_equal("by these functions", [pdu[0] for pdu in device.requests], [1, 2, 3, 4])
        tool.says("by addresses", f"read {port} plant.csv coil:12 input:0x31 0x30 holding:48 discrete:5h {WAIT}",
                  "pump=on", f"volume={0x10321031}", "setpoint=7 mm", "setpoint=7 mm", "door=closed (0x0000)")
        tool.fails("an address of another table", f"read {port} plant.csv input:12", 2, "has no register 'input:12'")
        tool.fails("of a pair", f"read {port} plant.csv input:0x32", 2, "is the second word of volume")
        tool.run(f"read {port} plant.csv pump valve level --csv {WAIT}")
        tool.check("as CSV", tool.last.lines[0].endswith(",pump,valve,level (mm)") and
                   tool.last.lines[1].endswith(",1,0,4144"))
        device.requests.clear()
        tool.says("write", f"write {port} plant.csv valve=open setpoint=9 {WAIT}", "valve=open (0x0001)", "setpoint=9 mm")
        tool.is_equal("a coil by 05, a register by 06", writes_of(device), ["05000dff00", "0600300009"])
        device.requests.clear()
        tool.run(f"write {port} plant.csv pump=off", stdin="no\n")
        tool.err_has("a coil with the flag motion asks", "pump moves the machine")
        tool.is_equal("and is not written", writes_of(device), [])
        tool.says("but with --yes", f"write {port} plant.csv pump=off --yes {WAIT}", "pump=off")
        tool.is_equal("by 05", writes_of(device), ["05000c0000"])
        for words, text in [("pump=2", "'2' is outside 0 .. 1"), ("pump=maybe", "'maybe' is neither on nor off"),
                            ("valve=ajar", "'ajar' is none of 0 shut, 1 open"), ("door=open", "read-only"),
                            ("level=1", "read-only")]:
            tool.fails(f"write {words}", f"write {port} plant.csv {words}", 2, text)
        device.requests.clear()
        tool.says("on and off are for a coil with names too", f"write {port} plant.csv valve=on valve=off valve=1 {WAIT}",
                  "valve=open (0x0001)", "valve=shut (0x0000)", "valve=open (0x0001)")
        tool.is_equal("and what they always are", writes_of(device), ["05000dff00", "05000d0000", "05000dff00"])
        tool.write("inverse.csv", "address,name,table,access,names,flags\n12,lamp,coil,rw,0=on;1=dark,\n13,fan,coil,rw,1=on,\n")
        device.requests.clear()
        tool.says("but a name of the row wins", f"write {port} inverse.csv lamp=on fan=on fan=off {WAIT}",
                  "lamp=on (0x0000)", "fan=on (0x0001)", "fan=off")
        tool.is_equal("with its code", writes_of(device), ["05000c0000", "05000dff00", "05000d0000"])
        tool.fails("and the other word is none", f"write {port} inverse.csv lamp=off", 2, "'off' is none of 0 on, 1 dark")
        tool.run(f"backup {port} plant.csv {WAIT}")
        tool.check("backup: holding registers", [line.split("=")[0] for line in tool.last.lines[1:-1]] == ["setpoint"])
    shown = tool.run("map plant.csv --long --profile").out
    tool.write("again.csv", shown.replace("name = plant", "name = again"))
    tool.is_equal("map, file, map", tool.run("map again.csv --long --profile").out.replace("= again", "= plant"), shown)
    tool.check("map: a coil", "0x000C,pump,1,bool,rw,no,,,,,,,1,,\"Runs the pump.\",motion,,,coil,,,,,\n" in shown)
    tool.says("map: a coil in words", "map plant.csv pump", "pump", "Runs the pump.", "", "address    0x000C",
              "table      coil", "type       bool", "access     read and write", "range      not stated",
              "default    not stated", "written    the manual does not say when",
              "note       a write moves the machine")


@scene()
def consent(tool: Tool):
    """A write that may move a machine asks; so does every write where the file does not say what does."""
    tool.write("lift.csv", "address,name,access,flags\n0x10,target,rw,motion\n0x11,start,rw,trigger\n0x12,ramp,rw,\n")
    tool.write("bare.csv", "address,name,access\n0x10,target,rw\n")
    device = filled()
    with on_terminal(device) as port:
        for name, words, text in [
            ("motion", "lift.csv target=1", "warning: target moves the machine"),
            ("trigger", "lift.csv start=1", "warning: start acts as it is written"),
            ("no column flags", "bare.csv target=1", "target is in a file without the column flags: who knows"),
        ]:
            ended = tool.run(f"write {port} {words}", stdin="no\n")
            tool.check(f"{name}: asks", ended.status == 1 and text in ended.err and "not confirmed" in ended.err)
            tool.is_equal(f"{name}: writes nothing", writes_of(device), [])
            tool.check(f"{name}: writes with --yes", tool.run(f"write {port} {words} --yes {WAIT}").status == 0)
            tool.check(f"{name}: and has written", len(writes_of(device)) == 1)
            device.requests.clear()
        tool.says("another register does not ask", f"write {port} lift.csv ramp=5 {WAIT}", "ramp=5")


@scene()
def watchdogs(tool: Tool):
    """Only what may have a watchdog and move is said to be fed."""
    tool.write("lift.csv", "address,name,access,flags\n0x10,target,rw,motion\n0x12,ramp,rw,\n")
    tool.write("relay.csv", "address,name,access,flags\n0x10,delay,rw,\n")
    tool.write("meter.csv", "address,name\n0x10,voltage\n")
    tool.write("bare.csv", "address,name,access\n0x10,target,rw\n")
    with on_terminal(filled()) as port:
        for words, fed in [("meter.csv 0x10", ""), ("relay.csv delay", ""),
                           ("lift.csv target", "these requests feed the device's watchdog if it has one"),
                           ("bare.csv target", "these requests feed the device's watchdog if it has one"),
                           ("raw 0x10", "these requests feed the device's watchdog if it has one")]:
            tool.run(f"watch {port} {words} --count 1 --interval 1 {WAIT}")
            tool.check(f"watch {words}", tool.last.status == 0 and fed in tool.last.err and
                       ("watchdog" in tool.last.err) == bool(fed), tool.found())
    for drive, has_one in ("zlac8015d", True), ("yako-closed-loop", False), ("c630s", False):
        with tool.simulated(drive):
            register = {"zlac8015d": "bus_voltage", "yako-closed-loop": "status_word", "c630s": "actual_speed"}[drive]
            tool.run(f"watch drive {drive} {register} --count 1 --interval 1")
            tool.check(f"watch {drive}", tool.last.status == 0 and
                       ("these requests feed the drive's watchdog; motors may run on" in tool.last.err) == has_one, tool.found())


@scene()
def parameters(tool: Tool):
    tool.write("meter.csv", METER.replace("0x1FF,beyond,u16,ro,,,,,,,,\n", ""))
    device = filled()
    device.holding[0x36] = 7
    with on_terminal(device) as port:
        tool.exits("backup", f"backup {port} meter.csv saved.txt {WAIT}", 0)
        saved = tool.lines("saved.txt")
        tool.is_equal("backup: the parameters without the trigger", [line.split("=")[0] for line in saved[1:-1]],
                      ["ratio", "mode", "node", "span", "offset", "relays"])
        tool.check("backup: of this device", " device=meter rows=6" in saved[0])
        device.holding[0x30], device.holding[0x33], device.holding[0x36] = 50, 9, 8
        device.requests.clear()
        tool.says("restore --dry-run", f"restore {port} meter.csv saved.txt --dry-run {WAIT}",
                  "ratio=0.50 times -> 1.00 times", "offset=8 -> 7")
        tool.err_has("and what it costs", "writes into the EEPROM: 1")
        tool.run(f"restore {port} meter.csv saved.txt", stdin="no\n")
        tool.err_has("restore asks", "not confirmed, nothing was written")
        tool.is_equal("and writes nothing", writes_of(device), [])
        tool.says("restore", f"restore {port} meter.csv saved.txt --yes {WAIT}", "ratio=1.00 times", "offset=7")
        tool.is_equal("restore: not the settings of the line", device.holding[0x33], 9)
        tool.fails("no save", f"restore {port} meter.csv saved.txt --save", 2, "meter has no command to save")
        tool.fails("another device's", f"restore {port} zlac8015d saved.txt", 2, "it is of a meter, not of a zlac8015d")
        tool.write("lift.csv", METER.replace("0x30,ratio,u16,rw,0.01,times,1,1000,100,,",
                                             "0x30,ratio,u16,rw,0.01,times,1,1000,100,motion,"))
        tool.fails("restore of a machine", f"restore {port} lift.csv saved.txt --yes", 2,
                   "lift.csv: restore is refused, since ratio moves the machine")
        tool.write("slow.csv", "address,name,access,when,flags\n0x30,ratio,rw,stopped,\n")
        tool.fails("restore of a motor's parameters", f"restore {port} slow.csv saved.txt --yes", 2,
                   "slow.csv: restore is refused, since ratio is written only while a motor stands")
        tool.write("bare.csv", "# name = meter\naddress,name,access\n0x30,ratio,rw\n")
        tool.fails("restore without flags", f"restore {port} bare.csv saved.txt --yes", 2,
                   "bare.csv: restore is refused, since the file has no column flags")
        tool.run(f"backup {port} bare.csv {WAIT}")
        tool.check("backup without flags", tool.last.status == 0 and "ratio=100 # 100" in tool.last.out)
        tool.err_has("warns", "bare.csv has no column flags")


@scene(("zlac8015d", "left_max_current=12.5", "status_word bus_voltage left_target_position motor_temperature"),
       ("yako-closed-loop", "homing_method=mechanical_stop_1 home_offset=-70000",
        "homing_method home_offset pair_word_order"),
       ("c630s", "jog_speed=50 gear_1_numerator=70000", "jog_speed gear_1_numerator status_word"))
def drive_by_its_file(tool: Tool, device: str, written: str, read: str):
    """A drive by its map as a file is as by its name, but for what only the tool knows of it."""
    tool.write("drive.csv", tool.run(f"map {device} --long --profile").out)
    registers = read if device != "c630s" else "jog_speed gear_1_numerator"
    with tool.simulated(device):
        results = []
        for word in (device, "drive.csv"):
            results.append([])
            for command in (f"write drive {word} {written}", f"read drive {word} {registers}",
                            f"backup drive {word}"):
                ended = tool.run(command)
                results[-1].append((ended.status, ended.out, ended.err))
            tool.check(f"{device} by {word}: each is done", all(status == 0 for status, _, _ in results[-1]),
                       results[-1])
        tool.is_equal(f"{device}: the same output and warnings", results[1], results[0])
        tool.write("saved.txt", results[0][2][1])
        tool.fails(f"{device}: restore needs what no file has", "restore drive drive.csv saved.txt --yes", 2,
                   "drive.csv: restore is refused, since ")


@scene()
def all_tables_explained(tool: Tool):
    tool.write("plant.csv", PLANT)
    frames = [
        ("> ", "04 0030 0001", "read level (0x0030) as input registers"),
        ("> ", "03 0030 0001", "read setpoint (0x0030)"),
        ("> ", "01 000C 0003", "read pump (0x000C), valve (0x000D), coil 0x000E"),
        ("< ", "01 01 02", "response, pump = off, valve = open (0x0001), coil 0x000E = off"),
        ("> ", "02 0004 0002", "read level_high (0x0004), door (0x0005)"),
        ("< ", "02 01 01", "response, level_high = on, door = closed (0x0000)"),
        ("> ", "05 000D 0000", "write valve (0x000D) = shut (0x0000)"),
        ("< ", "05 000D 0000", "response, valve (0x000D) = shut (0x0000) written"),
        ("> ", "0F 000C 0002 01 03", "write pump (0x000C) = on, valve (0x000D) = open (0x0001)"),
        ("< ", "0F 000C 0002", "response, pump (0x000C), valve (0x000D) written"),
        ("< ", "8F 02", "response, exception 2 (illegal data address) to "
                        "write pump (0x000C) = on, valve (0x000D) = open (0x0001)"),
    ]
    lines = "".join(f"{arrow}{framed(pdu)}\n" for arrow, pdu, _ in frames)
    tool.run("explain plant.csv:1 zlac8015d:2", stdin=f"{lines}> {framed('01 000C 0001', node=2)}\n")
    tool.out_is("explain: all tables", *(f"node 1: {words}" for _, _, words in frames), "node 2: read coil 0x000C")
    # As many coils as a response has, each with the longest names.
    rows = "".join(f"{i},{'a' * 43}{i:04},coil,ro,0=no{'a' * 45};1=on{'a' * 45}\n" for i in range(2000))
    tool.write("wide.csv", f"address,name,table,access,names\n{rows}")
    tool.run("explain wide.csv", stdin=f"{framed('01 0000 07D0')}\n{framed('01 FA' + 250 * '00')}\n")
    tool.check("explain: 2000 coils with names", tool.last.status == 0 and len(tool.last.lines) == 2 and
               tool.last.lines[1].endswith(f"{'a' * 43}1999 = no{'a' * 45} (0x0000)"))


@scene()
def codes_of_numbers(tool: Tool):
    """A number with a unit, some of whose values are codes: also outside its range."""
    tool.write("heater.csv", "address,name,type,access,scale,unit,min,max,default,flags,names\n"
               "3,limit,u16,rw,1,%,0,100,100,,255=no limit\n4,room,i16,rw,0.1,degC,,,250,,0x7FFF=no sensor;-1=fault\n")
    device = Device()
    device.holding[3:5] = [100, 0xFF06]
    with on_terminal(device) as port:
        on = f"{port} heater.csv"
        tool.says("a value with its unit", f"read {on} limit room {WAIT}", "limit=100 %", "room=-25.0 degC")
        tool.says("is written with and without it", f"write {on} limit=50 {WAIT}", "limit=50 %")
        device.requests.clear()
        tool.says("so is a code, by name", f"write {on} limit=no_limit {WAIT}", "limit=no_limit (0x00FF)")
        tool.says("and by number", f"write {on} limit=255 {WAIT}", "limit=no_limit (0x00FF)")
        tool.is_equal("06 each", writes_of(device), ["06000300ff", "06000300ff"])
        tool.fails("neither range nor code", f"write {on} limit=254", 2,
                   "limit: '254' is outside 0 % .. 100 %; it takes 255 no_limit")
        tool.fails("a name that it has not", f"write {on} limit=unlimited", 2,
                   "limit: 'unlimited' is no number; it takes 255 no_limit")
        device.holding[4] = 0x7FFF
        tool.says("a code when read", f"read {on} room {WAIT}", "room=no_sensor (0x7FFF)")
        tool.run(f"read {on} limit room --csv {WAIT}")
        tool.check("as CSV a code is no number", tool.last.lines[0].endswith(",limit (%),room (degC)") and
                   tool.last.lines[1].endswith(",nan,nan"))
        device.holding[3] = 7
        tool.run(f"read {on} limit room --json {WAIT}")
        tool.out_has("as JSON a code has a text, and a number none", '"limit":{"value":7,"unit":"%"},'
                     '"room":{"value":null,"unit":"degC","text":"no_sensor"}')
    tool.run("explain heater.csv", stdin=f"{framed('03 0003 0002')}\n{framed('03 04 0032 7FFF')}\n"
             f"{framed('06 0003 00FF')}\n{framed('06 0003 00FE')}\n")
    tool.out_has("explain: a number, a code", "limit = 50 %, room = no sensor (0x7FFF)")
    tool.out_has("explain: a code is not outside", "write limit (0x0003) = no limit (0x00FF) (request")
    tool.out_has("explain: another value is", "= 254 % (outside 0..100)")
    with tool.simulated("heater.csv"):
        on = "drive heater.csv"
        tool.says("sim: a code can be written", f"write {on} limit=no_limit", "limit=no_limit (0x00FF)")
    tool.run("map heater.csv --profile")
    tool.check("map gives the names back", "255=no limit" in tool.last.out)


@scene()
def explained(tool: Tool):
    tool.write("drive.csv", tool.run("map zlac8015d --profile").out)
    tool.write("meter.csv", METER)
    frames = "> 01 03 20 AB 00 02 BE 2B\n< 01 03 04 00 64 00 64 BA 07\n> 02 03 00 20 00 04 45 F0\n"
    named = tool.run("explain zlac8015d:1 raw:2", stdin=frames).lines
    found = tool.run("explain ./drive.csv:1 meter.csv:2", stdin=frames).lines
    tool.is_equal("explain: a drive by its file", found[:2], named[:2])
    tool.is_equal("explain: and a meter", found[2:], ["node 2: read energy (0x0020), balance (0x0022)"])
    tool.run("explain meter.csv", stdin="> 02 03 00 20 00 04 45 F0\n< 02 03 08 00 01 00 02 FF FF FF FE 33 C7\n")
    tool.is_equal("explain: each pair in its word order", tool.last.lines[1:],
                  ["node 2: response, energy = 65538, balance = -65537"])
    tool.fails("explain: two for one address", "explain meter.csv:2 ./drive.csv:2", 2, "two devices at address 2")
    device = filled()
    with on_terminal(device) as port:
        listening = tool.start(f"listen {port} ./drive.csv meter.csv:2")
        until(lambda: "listening on" in listening.err)
        tool.check("listen takes files", tool.ends(listening, signal.SIGINT).status == 0)


play_tool()
