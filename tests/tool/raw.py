# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A device without a map: coils, inputs and registers, with types, over every kind of port."""
import struct
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, on_terminal
from programs import Tool, play_tool, scene

WAIT = "--timeout 2000"
NOWHERE = "/dev/no-such-port"


def words_of(form: str, value) -> list[int]:
    return list(struct.unpack(">2H", struct.pack(form, value)))


def filled() -> Device:
    device = Device()
    device.coils[12] = device.coils[13] = device.coils[20] = True
    device.holding[0x10:0x12] = words_of(">f", 12.5)
    device.holding[0x20:0x22] = reversed(words_of(">f", -0.1))
    device.holding[0x30:0x32] = words_of(">i", -70000)
    device.holding[0x40:0x44] = words_of(">I", 4000000000) + words_of(">I", 1)
    device.holding[0x50:0x53] = [0xFFFB, 65531, 7]
    return device


READS = [
    ("coil:12", "coil:0x000C=on"),
    ("discrete:4", "discrete:0x0004=off"),
    ("coil:12:9", *[f"coil:0x{12 + i:04X}={'on' if i in (0, 1, 8) else 'off'}" for i in range(9)]),
    ("input:0x30", "input:0x0030=4144 (0x1030)"),
    ("input:0x30:2:i16", "input:0x0030=4144 (0x1030)", "input:0x0031=4145 (0x1031)"),
    ("holding:0x10", "holding:0x0010=16712 (0x4148)"),
    ("0x10:f32", "0x0010=12.5 (0x41480000)"),
    ("0x10:f32:hi", "0x0010=12.5 (0x41480000)"),
    ("0x20:f32:lo", "0x0020=-0.1 (0xBDCCCCCD)"),
    ("holding:0x30:i32", "holding:0x0030=-70000 (0xFFFEEE90)"),
    ("0x40:2:u32", "0x0040=4000000000 (0xEE6B2800)", "0x0042=1 (0x00000001)"),
    ("0x40:u32:2", "0x0040=4000000000 (0xEE6B2800)", "0x0042=1 (0x00000001)"),
    ("0x50:i16", "0x0050=-5 (0xFFFB)"),
    ("0x50:3", "0x0050=65531 (0xFFFB)", "0x0051=65531 (0xFFFB)", "0x0052=7 (0x0007)"),
]


@scene("pty", "tcp", "mbap")
def reads(tool: Tool, scheme: str):
    device = filled()
    with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
        name = port if scheme == "pty" else port.name
        for register, *lines in READS:
            tool.says(f"{scheme}: read {register}", f"read {name} raw {register} {WAIT}", *lines)
        tool.says(f"{scheme}: several in their order", f"read {name} raw coil:12 input:0x30 discrete:4 holding:0x10 {WAIT}",
                  "coil:0x000C=on", "input:0x0030=4144 (0x1030)", "discrete:0x0004=off", "holding:0x0010=16712 (0x4148)")
        codes = [pdu[0] for pdu in device.requests[-4:]]
        tool.is_equal(f"{scheme}: each by the function of its table", codes, [1, 4, 2, 3])
        tool.fails(f"{scheme}: a row that the device does not have", f"read {name} raw coil:300 {WAIT}", 1,
                   "coil:300: refused, exception 2 (illegal data address)")


@scene()
def numbers_of_manuals(tool: Tool):
    """Manuals number the tables 10001, 30001 and 40001 on; a frame counts each from 0."""
    with on_terminal(filled()) as port:
        for asked, number, first, meant in [("40001", 40001, 40001, "0x0000"),
                                            ("holding:40108:2", 40108, 40001, "holding:0x006B:2"),
                                            ("30013", 30013, 30001, "input:0x000C"),
                                            ("input:30013", 30013, 30001, "input:0x000C"),
                                            ("discrete:10001", 10001, 10001, "discrete:0x0000")]:
            tool.fails(asked, f"read {port} raw {asked} {WAIT}", 1,
                       f"; a manual that counts from {first} means {meant} by {number}")
        for asked in ["300", "10000", "40000", "0x9C41", "9C41h", "49999:1"]:
            tool.run(f"read {port} raw {asked} {WAIT}")
            is_told = "a manual that counts" in tool.last.err
            tool.is_equal(f"{asked}: told", is_told, asked == "49999:1")


WRITES = [
    ("coil:3=on", "coil:0x0003=on", "05 0003 FF00"),
    ("coil:3=off", "coil:0x0003=off", "05 0003 0000"),
    ("coil:12:3=on,off,1", "coil:0x000C=on", "0F 000C 0003 01 05"),
    ("0x60:f32=12.5", "0x0060=12.5 (0x41480000)", "10 0060 0002 04 4148 0000"),
    ("0x60:f32:lo=12.5", "0x0060=12.5 (0x41480000)", "10 0060 0002 04 0000 4148"),
    ("0x60:f32=0.1", "0x0060=0.1 (0x3DCCCCCD)", "10 0060 0002 04 3DCC CCCD"),
    ("0x60:i32=-70000", "0x0060=-70000 (0xFFFEEE90)", "10 0060 0002 04 FFFE EE90"),
    ("holding:0x60:2:u32:lo=1,2", "holding:0x0060=1 (0x00000001)", "10 0060 0004 08 0001 0000 0002 0000"),
    ("0x60:i16=-5", "0x0060=-5 (0xFFFB)", "06 0060 FFFB"),
    ("0x60=-5", "0x0060=65531 (0xFFFB)", "06 0060 FFFB"),
    ("0x60:2=50,-50", "0x0060=50 (0x0032)", "10 0060 0002 04 0032 FFCE"),
]


@scene("pty", "tcp", "mbap")
def writes(tool: Tool, scheme: str):
    device = filled()
    with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
        name = port if scheme == "pty" else port.name
        for assignment, first, request in WRITES:
            tool.run(f"write {name} raw {assignment} --yes {WAIT}")
            tool.check(f"{scheme}: write {assignment}", tool.last.status == 0 and tool.last.lines[0] == first)
            sent = [pdu.hex() for pdu in device.requests if pdu[0] > 4]
            tool.is_equal(f"{scheme}: its frame", sent[-1], bytes.fromhex(request).hex())
            tool.is_equal(f"{scheme}: is sent once", len(sent), 1)
            device.requests.clear()
        tool.run(f"write {name} raw coil:1=on", stdin="no\n")
        tool.check(f"{scheme}: a coil asks first", tool.last.status == 1 and not device.coils[1])


@scene()
def echoed_coil(tool: Tool):
    """The response to 05 equals its request."""
    device = filled()
    with on_terminal(device, echoes=True) as port:
        tool.run(f"write {port} raw coil:3=on --yes --timeout 300 --retries 0")
        tool.status_is("G3: a coil: the request's own echo is no response", 1)
        tool.check("G3: nothing is written after an echo", not device.coils[3])
        tool.err_has("which it says", "not sent, what came is the request's own echo: try --echo on")
        tool.says("with --echo on it is written", f"write {port} raw coil:3=on --yes --echo on {WAIT}", "coil:0x0003=on")
        tool.check("in the device", device.coils[3])


@scene("0", "255")
def peer_itself(tool: Tool, unit: str):
    """The device at the other end of Modbus TCP, which has no address on a line."""
    device = filled()
    with Gateway(device, "mbap", closes_after=3) as port:
        tool.says(f"unit {unit}: read", f"read {port.name} raw:{unit} coil:12 0x10:f32 input:0x30 0x30:i32 {WAIT}",
                  "coil:0x000C=on", "0x0010=12.5 (0x41480000)", "input:0x0030=4144 (0x1030)",
                  "0x0030=-70000 (0xFFFEEE90)")
        tool.says(f"unit {unit}: write", f"write {port.name} raw:{unit} coil:3=on 0x60=7 --yes {WAIT}",
                  "coil:0x0003=on", "0x0060=7 (0x0007)")
        tool.check("in the device", device.coils[3] and device.holding[0x60] == 7)
        tool.fails(f"unit {unit}: a row that it does not have", f"read {port.name} raw:{unit} 300 {WAIT}", 1,
                   "300: refused, exception 2 (illegal data address)")
        tool.run(f"watch {port.name} raw:{unit} coil:12 --count 1 {WAIT}")
        tool.out_has(f"unit {unit}: watch", "coil:0x000C=on")
        tool.is_equal("each request has the unit", set(port.units), {int(unit)})
        port.units.clear()
        tool.run(f"read {port.name} raw:1 coil:12 {WAIT}")
        tool.is_equal("a node behind it is another", port.units, [1])


@scene()
def records(tool: Tool):
    device = filled()
    device.holding[0x70:0x72] = words_of(">f", float("nan"))
    with on_terminal(device) as port:
        registers = "coil:12 0x10:f32 0x30:i32 input:0x30:2 0x70:f32"
        tool.run(f"read {port} raw {registers} --csv {WAIT}")
        tool.is_equal("CSV: a column a value", tool.last.lines[0].split(",")[3:],
                      ["coil:0x000C", "0x0010", "0x0030", "input:0x0030", "input:0x0031", "0x0070"])
        tool.is_equal("and numbers", tool.last.lines[1].split(",")[3:], ["1", "12.5", "-70000", "4144", "4145", "nan"])
        tool.run(f"read {port} raw {registers} --json {WAIT}")
        tool.out_has("JSON: the same", '"coil:0x000C":{"value":1},"0x0010":{"value":12.5},"0x0030":{"value":-70000}')
        tool.out_has("JSON: what is no number is null", '"0x0070":{"value":null}},"errors":{}')
        tool.run(f"watch {port} raw {registers} --count 1 {WAIT}")
        tool.out_has("watch shows them", "coil:0x000C=on, 0x0010=12.5 (0x41480000), 0x0030=-70000 (0xFFFEEE90)")


class Storm(Gateway):
    """Answers on its first connection once, then closes each connection for 1.5 s, as a gateway that has none free."""

    ANSWERS_AGAIN = 1.5

    def __init__(self, device: Device, scheme: str):
        self.begun = None  # when its first response was sent
        self.refused = 0
        super().__init__(device, scheme)

    def talk(self, connection):
        if self.begun is None:
            self.closes_after = 1
            super().talk(connection)
            self.begun, self.closes_after = time.monotonic(), 0
        elif time.monotonic() - self.begun < self.ANSWERS_AGAIN:
            self.refused += 1
        else:
            super().talk(connection)


@scene("tcp", "mbap")
def storm(tool: Tool, scheme: str):
    with Storm(filled(), scheme) as gateway:
        tool.run(f"read {gateway.name} raw 0 1 2 {WAIT}")
        tool.check("it was refused", gateway.refused > 0)
        tool.check("about ten connections a second at first, then fewer", gateway.refused <= 20, str(gateway.refused))


@scene()
def refused(tool: Tool):
    """Before a port is opened."""
    for words, text in [
        ("read PORT raw cols:12", "'cols:12' is no ADDRESS, ADDRESS:COUNT or [TABLE:]ADDRESS[:COUNT][:TYPE][:hi|lo]"),
        ("read PORT raw coil:", "''"),
        ("read PORT raw coil:12:", "''"),
        ("read PORT raw coil:12:i16", "is a bit, which has no type"),
        ("read PORT raw 0x10:i15", "'i15'; did you mean i16"),
        ("read PORT raw 0x10:i16:lo", "hi and lo are for u32, i32 and f32"),
        ("read PORT raw 0x10:i16:u16", "'u16'"),
        ("read PORT raw 0x10:2:3", "'3'"),
        ("read PORT raw 0xFFFF:f32", "is no ADDRESS or ADDRESS:COUNT (0x0000 to 0xFFFF, at most 62)"),
        ("read PORT raw coil:0:2001", "at most 2000"),
        ("read PORT raw 0:126", "at most 125"),
        ("read PORT zlac8015d coil:12", "zlac8015d has no register 'coil:12'"),
        ("write PORT raw input:3=1 --yes", "input:3: input registers are read-only"),
        ("write PORT raw discrete:3=on --yes", "discrete:3: discrete inputs are read-only"),
        ("write PORT raw coil:3=2 --yes", "coil:3: '2' is neither on nor off"),
        ("write PORT raw 0:i16=40000 --yes", "'40000' is no whole number from -32768 to 32767"),
        ("write PORT raw 0:u16=-1 --yes", "'-1' is no whole number from 0 to 65535"),
        ("write PORT raw 0:u32=4294967296 --yes", "'4294967296' is no whole number from 0 to 4294967295"),
        ("write PORT raw 0:f32=1e39 --yes", "'1e39' is no number of single precision"),
        ("write PORT raw 0:f32=nan --yes", "'nan' is no number of single precision"),
        ("write PORT raw 0:2:f32=1 --yes", "1 values for 2 registers (at most 61)"),
        ("read PORT raw:0 1", "unit 0 is the device itself on mbap://HOST; on a serial line 0 is a broadcast"),
        ("read PORT raw:255 1", "unit 255 is the device itself on mbap://HOST; on a serial line 255 is reserved"),
        ("read tcp://127.0.0.1:9 raw:0 1", "take a node from 1 to 247"),
        ("write PORT raw:0 1=1 --yes", "which no node responds to"),
        ("watch PORT raw:255 1", "take a node from 1 to 247"),
        ("listen PORT raw:0", "take a node from 1 to 247"),
        ("explain raw:255", "take a node from 1 to 247"),
        ("read mbap://127.0.0.1:9 raw:248 1", "'248' is no node address of raw: 1 to 247"),
        ("read mbap://127.0.0.1:9 zlac8015d:0 1", "'0' is no node address of zlac8015d"),
        ("write PORT raw coil:0:3=on,off --yes", "2 values for 3 coils (at most 1968)"),
    ]:
        tool.fails(words, words.replace("PORT", NOWHERE), 2, text)


play_tool()
