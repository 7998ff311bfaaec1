# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Values of every form in files that describe devices: what real devices send, and what each command makes of it."""
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from programs import Tool, play_tool, scene
from standard_frames import framed

WAIT = "--timeout 2000"

# Files of real devices, words by table and address, a register, and what `read` prints.
METERS = {
    "sdm120": """# baud = 2400
address,name,table,type,access,unit
0x0000,voltage,input,f32,ro,V
0x000C,active_power,input,f32,ro,W
0x0048,import_energy,input,f32,ro,kWh
""",
    "growatt": """address,name,table,words,type,access,scale,unit,min,max,flags,names
0,status,input,1,u16,ro,,,,,,0=waiting;1=normal;3=fault
1,pv_power,input,2,u32,ro,0.1,W,,,,
3,active_power_limit,holding,1,u16,rw,1,%,0,100,,255=no limit
23,serial_number,holding,5,text,ro,,,,,,
""",
    "deye": """# word_order = low
address,name,type,access,scale,unit,word_order,bits,offset
60,daily_energy,u32,ro,0.1,kWh,high,,
63,hour,u16,rw,,h,,high,
63,minute,u16,rw,,min,,low,
72,total_energy,u32,ro,0.1,kWh,,,
182,battery_temperature,u16,ro,0.1,degC,,,-1000
""",
    "sunspec": """address,name,words,type,access,unit,none,factor
40,manufacturer,8,text,ro,,,
72,current,1,u16,ro,A,0xFFFF,10^current_sf
76,current_sf,1,i16,ro,,-0x8000,
""",
    "sma": """address,name,table,type,access,unit,none
0x21,total_energy,input,u64,ro,Wh,0xFFFFFFFFFFFFFFFF;0x8000000000000000
0x27,ac_power,input,i32,ro,W,0x80000000
""",
    "bits": """# byte_order = low
address,name,words,type,access,scale,unit,byte_order,factor,word_order
0x10,model,4,text,ro,,,,,
0x14,volts,,f32,ro,,V,,,low
0x16,plain,,u16,ro,,,,,
0x17,digits,,bcd16,ro,,,,,
0x18,current,,sm32,ro,0.001,A,high,,
0x1A,scaled,,i32,ro,0.001,A,,ratio,
0x1C,ratio,,u16,ro,0.1,times,,,
0x1D,co2,,u16,ro,,ppm,,,
0x1E,pressure,,f64,ro,,Pa,high,,
""",
}
READ = [
    ("sdm120", "input", 0, [0x4366, 0x199A], "voltage", "voltage=230.1 V"),
    ("sdm120", "input", 0x0C, [0xC32C, 0x9822], "active_power", "active_power=-172.59427 W"),
    ("sdm120", "input", 0x48, [0x7FC0, 0], "import_energy", "import_energy: no value"),
    ("sdm120", "input", 0x48, [0xFF80, 0], "import_energy", "import_energy: no value"),
    ("sdm120", "input", 0x48, [0, 1], "import_energy", "import_energy=1e-45 kWh"),
    ("sdm120", "input", 0x48, [0x7F7F, 0xFFFF], "import_energy", "import_energy=3.4028235e+38 kWh"),
    ("growatt", "holding", 23, [0x4B50, 0x4537, 0x4230, 0x3132, 0], "serial_number", 'serial_number="KPE7B012"'),
    ("growatt", "holding", 23, [0x4120, 0x0A22, 0, 0x2020, 0], "serial_number", 'serial_number="A \\x0A\\x22"'),
    ("growatt", "holding", 3, [0x64], "active_power_limit", "active_power_limit=100 %"),
    ("growatt", "holding", 3, [0xFF], "active_power_limit", "active_power_limit=no_limit (0x00FF)"),
    ("growatt", "input", 1, [1, 0], "pv_power", "pv_power=6553.6 W"),
    ("deye", "holding", 182, [0x04E5], "battery_temperature", "battery_temperature=25.3 degC"),
    ("deye", "holding", 182, [0], "battery_temperature", "battery_temperature=-100.0 degC"),
    ("deye", "holding", 60, [1, 0x01D0], "daily_energy", "daily_energy=6600.0 kWh"),
    ("deye", "holding", 72, [0x01D0, 1], "total_energy", "total_energy=6600.0 kWh"),
    ("deye", "holding", 63, [0x0C1E], "hour", "hour=12 h"),
    ("deye", "holding", 63, [0x0C1E], "minute", "minute=30 min"),
    ("sunspec", "holding", 72, [0x04D2, 0, 0, 0, 0xFFFE], "current", "current=12.34 A"),
    ("sunspec", "holding", 72, [0xFFFF, 0, 0, 0, 0xFFFE], "current", "current: no value"),
    ("sunspec", "holding", 72, [0x04D2, 0, 0, 0, 0x8000], "current", "current: no value"),
    ("sunspec", "holding", 72, [0x04D2, 0, 0, 0, 11], "current", "current: no value"),
    ("sunspec", "holding", 72, [0x04D2, 0, 0, 0, 10], "current", "current=12340000000000 A"),
    ("sma", "input", 0x21, [0, 1, 0, 2], "total_energy", "total_energy=4294967298 Wh"),
    ("sma", "input", 0x21, [0xFFFF, 0xFFFF, 0xFFFF, 0xFFFE], "total_energy", "total_energy=18446744073709551614 Wh"),
    ("sma", "input", 0x21, [0xFFFF] * 4, "total_energy", "total_energy: no value"),
    ("sma", "input", 0x21, [0x8000, 0, 0, 0], "total_energy", "total_energy: no value"),
    ("sma", "input", 0x27, [0x8000, 0], "ac_power", "ac_power: no value"),
    ("sma", "input", 0x27, [0x8000, 1], "ac_power", "ac_power=-2147483647 W"),
    ("bits", "holding", 0x10, [0x4548, 0x5441, 0x0031, 0], "model", 'model="HEAT1"'),
    ("bits", "holding", 0x14, [0x9A19, 0x6643], "volts", "volts=230.1 V"),
    ("bits", "holding", 0x16, [0x0102], "plain", "plain=258"),
    ("bits", "holding", 0x17, [0x3412], "digits", "digits=1234"),
    ("bits", "holding", 0x17, [0x0A12], "digits", "digits=no number (0x120A)"),
    ("bits", "holding", 0x18, [0x8000, 0x0BB8], "current", "current=-3.000 A"),
    ("bits", "holding", 0x1A, [0xFFFF, 0xFEFF, 30], "scaled", "scaled=-0.0060 A"),
    ("bits", "holding", 0x1D, [415], "co2", "co2=415 ppm"),
    ("bits", "holding", 0x1E, [0x40F8, 0xBCD0, 0, 0], "pressure", "pressure=101325 Pa"),
]


def put(device: Device, table: str, first: int, words: list[int]):
    rows = device.holding if table == "holding" else device.input_registers
    rows[first : first + len(words)] = words


@scene()
def reads(tool: Tool):
    """What real devices send, and what it means."""
    for name, text in METERS.items():
        tool.write(f"{name}.csv", text)
    device = Device()
    with on_terminal(device) as port:
        for name, table, first, words, register, shown in READ:
            put(device, table, first, words)
            tool.says(f"{name}: {shown}", f"read {port} {name}.csv {register} {WAIT}", shown)
        put(device, "holding", 72, [0x04D2, 0, 0, 0, 0xFFFE])
        tool.says("watch", f"watch {port} sunspec.csv current --count 1 {WAIT}", "0.000 current=12.34 A")
        put(device, "holding", 72, [0xFFFF])
        tool.says("watch: no value", f"watch {port} sunspec.csv current current_sf --count 1 {WAIT}",
                  "0.000 current: no value, current_sf=-2")


@scene()
def records(tool: Tool):
    """No value is nan in CSV and null in JSON; a text is a text."""
    tool.write("sunspec.csv", METERS["sunspec"])
    tool.write("bits.csv", METERS["bits"])
    tool.write("sma.csv", METERS["sma"])
    device = Device()
    put(device, "holding", 40, [0x4142, 0x222C, 0, 0, 0, 0, 0, 0])
    put(device, "holding", 72, [0xFFFF, 0, 0, 0, 0xFFFE])
    put(device, "input", 0x21, [0xFFFF, 0xFFFF, 0xFFFF, 0xFFFE])
    put(device, "holding", 0x1D, [415])
    with on_terminal(device) as port:
        tool.run(f"read {port} sunspec.csv current manufacturer --csv {WAIT}")
        tool.check("CSV", tool.last.lines[0].endswith(",current (A),manufacturer") and
                   tool.last.lines[1].endswith(",nan,AB\\x22"), tool.found())
        tool.run(f"read {port} sunspec.csv current manufacturer --json {WAIT}")
        registers = json.loads(tool.last.out)["registers"]
        tool.is_equal("JSON", registers, {"current": {"value": None, "unit": "A"}, "manufacturer": {"value": "AB\\x22,"}})
        tool.run(f"read {port} bits.csv co2 --json {WAIT}")
        tool.is_equal("JSON, with a unit of the device's own", json.loads(tool.last.out)["registers"],
                      {"co2": {"value": 415, "unit": "ppm"}})
        tool.run(f"read {port} sma.csv total_energy --csv {WAIT}")
        tool.check("64 bits", tool.last.lines[1].endswith(",18446744073709551614"))


SEVEN = """address,name,table,type,access,factor
0x10,first,,u16,rw,
0x11,second,,f32,ro,
0x13,third,,u64,ro,
0x17,scaled,,i16,ro,10^exponent
0x18,exponent,,i16,ro,
0x19,last,,u16,ro,
0x20,alone,,u16,ro,
0x00,one,coil,bool,rw,
0x01,two,coil,bool,rw,
0x02,three,coil,bool,ro,
"""


@scene()
def requests(tool: Tool):
    """Adjacent rows are one request, as in the library; so are a value and its scale."""
    tool.write("seven.csv", SEVEN)
    tool.write("short.csv", "# max_read = 3\n" + SEVEN)
    tool.write("bits.csv", "address,name,type,bits\n1,a,u16,0..3\n1,b,u16,4\n1,c,i16,high\n2,d,u16,\n")
    device = Device()
    with on_terminal(device) as port:
        def asked(words: str) -> list[str]:
            device.requests.clear()
            tool.run(f"{words} {WAIT}")
            tool.check(f"{words.split()[2:]} is read", tool.last.status == 0, tool.found())
            return [pdu.hex() for pdu in device.requests]

        tool.is_equal("seven rows", asked(f"read {port} seven.csv last first second third scaled exponent"),
                      ["030010000a"])
        tool.is_equal("a value and its scale", asked(f"read {port} seven.csv scaled"), ["0300170002"])
        tool.is_equal("a gap", asked(f"read {port} seven.csv alone last"), ["0300190001", "0300200001"])
        tool.is_equal("coils", asked(f"read {port} seven.csv three one two"), ["0100000003"])
        tool.is_equal("two rounds of watch", asked(f"watch {port} seven.csv first second --count 2 --interval 1"),
                      ["0300100003", "0300100003"])
        tool.is_equal("no more than the device reads",
                      asked(f"read {port} short.csv first second scaled exponent last"), ["0300100003", "0300170003"])
        tool.is_equal("parts of a register", asked(f"read {port} bits.csv a b c d"), ["0300010002"])
        tool.is_equal("a row twice", asked(f"read {port} seven.csv first first"), ["0300100001"])
        device.requests.clear()
        device.holding = device.holding[:0x19]
        tool.run(f"read {port} seven.csv exponent last {WAIT}")
        tool.check("what is refused in a block is asked alone", tool.last.out == "exponent=0\n" and
                   "last: refused, exception 2" in tool.last.err and len(device.requests) == 3, tool.found())


WRITTEN = """# name = written
address,name,words,type,access,scale,unit,min,max,flags,names,word_order,bits,offset,none,factor,byte_order
0x10,level,,f32,rw,,m,-10,100,,,,,,,,
0x12,mass,,f64,rw,0.001,kg,,,,,,,,,,
0x16,total,,u64,rw,0.1,kWh,,,,,,,,,,
0x1A,count,,i64,rw,,,,,,,low,,,,,
0x1E,name,3,text,rw,,,,,,,,,,,,
0x21,swapped,,f32,rw,,V,,,,,low,,,,,low
0x23,time,,bcd16,rw,,,0,2359,,,,,,,,
0x24,current,,sm16,rw,0.1,A,,,,,,,,,,
0x25,mode,,u16,rw,,,,,,0=auto;1=manual,,0..3,,,,
0x25,speed,,i16,rw,,r/min,,,,,,4..15,,,,
0x26,room,,u16,rw,0.1,degC,0,400,,0x7FFF=off,,,-1000,0xFFFF,,
0x27,scaled,,i16,rw,,W,,,,,,,,,10^power,
0x28,power,,i16,ro,,,,,,,,,,,,
0x29,pair,,u32,rw,,,,,,0x80000000=forever;b4=hot,,,,,,
"""
WRITES = [
    ("level=21.37", "level=21.37 m", "10001000020441aaf5c3"),
    ("level=-10", "level=-10 m", "100010000204c1200000"),
    ("level=0x7FC00000", "level: no value", "1000100002047fc00000"),
    ("mass=0.0123", "mass=0.0123 kg", "1000120004084028999999" + "99999a"),
    ("total=1844674407370955161.5", "total=1844674407370955161.5 kWh", "100016000408" + "ff" * 8),
    ("count=-9223372036854775808", "count=-9223372036854775808", "10001a000408" + "00" * 6 + "8000"),
    ("name=AB\\x0A", 'name="AB\\x0A"', "10001e00030641420a000000"),
    ('name=""', 'name=""', "10001e000306000000000000"),
    ("swapped=230.1", "swapped=230.1 V", "1000210002049a196643"),
    ("time=2359", "time=2359", "0600232359"),
    ("current=-0.5", "current=-0.5 A", "0600248005"),
    ("room=25.3", "room=25.3 degC", "06002604e5"),
    ("room=off", "room=off (0x7FFF)", "0600267fff"),
    ("room=0xFFFF", "room: no value", "060026ffff"),
    ("scaled=0x0005", "scaled=5 * 10^power W", "0600270005"),
    ("pair=forever", "pair=forever (0x80000000)", "10002900020480000000"),
    ("pair=hot", "pair=hot (0x00000010)", "10002900020400000010"),
]
REFUSED = [
    ("level=nan", "'nan' is no finite number of f32"), ("level=inf", "'inf' is no finite number"),
    ("level=-infinity", "no finite number"), ("level=1e39", "no finite number"), ("level=high", "no finite number"),
    ("level=100.00001", "'100.00001' is outside -10 m .. 100 m"), ("level=0x100000000", "no finite number"),
    ("mass=1e309", "no finite number of f64"), ("mass=", "no finite number"),
    ("total=1844674407370955161.6", "is no number"), ("total=1844674407370955162", "is beyond u64"), ("total=-0.1", "is beyond u64"),
    ("total=0.05", "no whole number of counts"), ("count=9223372036854775808", "is beyond i64"),
    ("count=-9223372036854775809", "is beyond i64"), ("count=nan", "'nan' is no number"),
    ("name=ABCDEFG", "has more than 6 characters"), ("name=\\", "begins none such as \\x0A"),
    ("time=2360", "is outside 0 .. 2359"), ("time=10000", "is outside 0 .. 2359"), ("time=0x23AB", "is outside"),
    ("current=3276.8", "is beyond sm16"), ("mode=2x", "no number"), ("mode=16", "is beyond its bits"),
    ("speed=2048", "is beyond its bits"), ("room=40.1", "is outside 0.0 degC .. 40.0 degC"),
    ("room=6453.5", "means no value"), ("scaled=5", "another row sets its scale: give the raw content, 0x...."),
    ("pair=cold", "is none of 0x80000000 forever, bit 4 hot"),
]


def writes_of(device: Device) -> list[str]:
    return [pdu.hex() for pdu in device.requests if pdu[0] > 4]


@scene()
def writes(tool: Tool):
    tool.write("written.csv", WRITTEN)
    device = Device()
    device.holding[0x25] = 0xFFF1
    with on_terminal(device) as port:
        for words, shown, pdu in WRITES:
            device.requests.clear()
            tool.says(f"write {words}", ["write", port, "written.csv", words, *WAIT.split()], shown)
            tool.is_equal(f"write {words}: the request", writes_of(device), [pdu])
        for words, why in REFUSED:
            tool.fails(f"write {words} is refused", ["write", port, "written.csv", words], 2, why)
        device.requests.clear()
        tool.run(f"write {port} written.csv speed=-2 mode=auto {WAIT}")
        tool.out_is("parts of a register", "speed=-2 r/min", "mode=auto (0x0)")
        tool.err_has("say what is done", "speed is a part of register 0x0025: the register is read, and written with its "
                     "other bits as they are")
        tool.is_equal("and keep the others", writes_of(device), ["060025ffe1", "060025ffe0"])


@scene()
def blocks(tool: Tool):
    """A device that takes single rows by 10h and 0Fh alone."""
    tool.write("block.csv", "# writes_blocks_only = yes\naddress,name,table,access,flags\n"
               "0x10,ramp,,rw,\n0x11,lamp,coil,rw,\n")
    device = Device()
    with on_terminal(device) as port:
        tool.says("one register, one coil", f"write {port} block.csv ramp=5 lamp=on {WAIT}", "ramp=5", "lamp=on")
        tool.is_equal("by 10h and 0Fh", writes_of(device), ["1000100001020005", "0f001100010101"])
    tool.run("map block.csv --profile")
    tool.out_has("map has the key", "# writes_blocks_only = yes\n")
    with tool.simulated("block.csv"):
        tool.says("the simulated device takes it", "write drive block.csv ramp=7 lamp=on", "ramp=7", "lamp=on")
        tool.run("write drive raw 0x10=5 --yes")
        tool.check("and no function 06", tool.last.status == 1 and "exception 1" in tool.last.err, tool.found())


RELAY = """address,name,table,access,flags,names
0,relay,coil,rw,,0x5500=toggle;0x0200=flash
1,other,coil,rw,,
0xFF,all_relays,coil,wo,,0x5500=toggle
"""


@scene()
def relays(tool: Tool):
    """A name of a coil above 1 is the word that function 05 sends."""
    tool.write("relay.csv", RELAY)
    device = Device()
    with on_terminal(device) as port:
        tool.says("toggle", f"write {port} relay.csv relay=toggle {WAIT}", "relay=toggle (0x5500)")
        tool.is_equal("is a word of function 05", writes_of(device), ["0500005500"])
        tool.is_equal("and nothing is read after it", device.requests[-1].hex(), "0500005500")
        tool.says("on and off", f"write {port} relay.csv relay=on relay=off {WAIT}", "relay=on", "relay=off")
        tool.says("read", f"read {port} relay.csv relay other {WAIT}", "relay=off", "other=off")
        tool.fails("no such word", f"write {port} relay.csv relay=0x5501", 2, "it takes 0x5500 toggle, 0x200 flash")
    frame = framed("0500005500")
    tool.run("explain relay.csv", stdin=f"> {frame}\n< {frame}\n")
    tool.out_is("explain has the name", "node 1: write relay (0x0000) = toggle (0x5500)",
                "node 1: response, relay (0x0000) = toggle (0x5500) written")
    tool.write("twice.csv", RELAY.replace("0x0200", "0xFF00"))
    tool.fails("on has its own name", "map twice.csv", 2, "twice.csv:2: relay: '0xFF00' is no code of bool")
    with tool.simulated("relay.csv"):
        tool.says("the simulated device takes it", "write drive relay.csv relay=flash", "relay=flash (0x0200)")


class WriteOnly(Device):
    """Relays that repeat 05 and 06 and cannot be read."""

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        return pdu if pdu[0] in (5, 6) else b""


@scene()
def unreadable(tool: Tool):
    """Relays that cannot be read, on a line that is told that there is no echo."""
    tool.write("relay.csv", RELAY)
    device = WriteOnly()
    with on_terminal(device) as port:
        tool.says("are written", f"write {port} relay.csv all_relays=on --echo off --timeout 300", "all_relays=on")
        tool.says("by words too", f"write {port} relay.csv all_relays=toggle --echo off --timeout 300",
                  "all_relays=toggle (0x5500)")
        tool.is_equal("and nothing is read", [pdu.hex() for pdu in device.requests], ["0500ffff00", "0500ff5500"])
        tool.run(f"write {port} relay.csv all_relays=on --timeout 100 --retries 0")
        tool.check("without it the way is named", tool.last.status == 1 and "--echo off" in tool.last.err, tool.found())


@scene()
def served(tool: Tool):
    """`sim` serves each row, and keeps what is written."""
    for name, text in [*METERS.items(), ("written", WRITTEN)]:
        tool.write(f"{name}.csv", text)
        with tool.simulated(f"{name}.csv"):
            shown = [line.split(",") for line in tool.run(f"map {name}.csv").lines if not line.startswith("#")]
            names = [cells[1] for cells in shown[1:]]
            tool.run(["read", "drive", f"{name}.csv", *names])
            tool.check(f"{name}: each row is read", tool.last.status == 0 and len(tool.last.lines) == len(names),
                       tool.found())
            if name != "written":
                continue
            for words, value, _ in WRITES:
                tool.says(f"write {words}", ["write", "drive", "written.csv", words], value)
            tool.says("the last values are read", "read drive written.csv level name time speed room", "level: no value",
                      'name=""', "time=2359", "speed=0 r/min", "room: no value")
            tool.run("write drive written.csv level=20.5 speed=-7 mode=manual name=Q#7 total=12.3 room=20 count=-5")
            tool.says("a part keeps the others", "read drive written.csv mode speed", "mode=manual (0x1)", "speed=-7 r/min")
            tool.run("backup drive written.csv kept.txt")
            tool.out_is("backup")
            kept = [line.split(" # ")[0] for line in tool.lines("kept.txt")[1:-1]]
            tool.is_equal("backup has numbers, floats and texts", kept,
                          ["level=20.5", "mass=12.3", "total=123", "count=-5", 'name="Q#7"', "swapped=230.1", "time=2359",
                           "current=-5", "mode=1", "speed=-7", "room=200", "scaled=5", "pair=16"])
            tool.run("write drive written.csv level=1 speed=1 mode=auto name=other total=1 room=1 mass=1e-9")
            tool.run("restore drive written.csv kept.txt --yes")
            tool.status_is("restore", 0)
            tool.says("writes what differs", "read drive written.csv level speed mode name total room mass", "level=20.5 m",
                      "speed=-7 r/min", "mode=manual (0x1)", 'name="Q#7"', "total=12.3 kWh", "room=20.0 degC",
                      "mass=0.0123 kg")
            tool.run("restore drive written.csv kept.txt --yes")
            tool.err_has("the same bits come back", "0 of 13 parameters differ")
            tool.write("machine.txt", "servobus-machine format=1\n[box] device=written.csv node=1\nlevel=1.5 m # low\n"
                       'name="A#1" # a text\nspeed=3\ntotal=12.3\n')
            tool.run("diff drive machine.txt")
            tool.out_is("diff", "box.level 20.5 m -> 1.5 m", 'box.name "Q#7" -> "A#1"', "box.speed -7 r/min -> 3 r/min")
            tool.run("apply drive machine.txt --yes")
            tool.status_is("apply", 0)
            tool.says("writes the same", "read drive written.csv level name speed mode", "level=1.5 m", 'name="A#1"',
                      "speed=3 r/min", "mode=manual (0x1)")
            tool.run("doctor drive written.csv --long")
            tool.check("doctor has nothing to refuse", tool.last.status == 0 and "refused" not in tool.last.out, tool.found())


@scene()
def frames(tool: Tool):
    """explain names the parts of a register, and scales a row by another one of the frame."""
    for name in ("sunspec", "deye"):
        tool.write(f"{name}.csv", METERS[name])
    asked, came = framed("0300480005"), framed("030A04D2000000000000FFFE")
    tool.run("explain sunspec.csv", stdin=f"> {asked}\n< {came}\n")
    tool.out_has("a scaled row", "response, current = 12.34 A, ")
    tool.run("explain deye.csv", stdin=f"> {framed('06003F0C1E')}\n")
    tool.out_has("parts of a register", "minute (0x003F) = 30 min, hour (0x003F) = 12 h")


play_tool()
