# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""send: any request by its bytes. The device's answers are written out here."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, crc, on_terminal
from programs import Tool, play_tool, scene

WAIT = "--timeout 2000"
NOWHERE = "/dev/no-such-port"


def meter() -> Device:
    device = Device()
    device.holding[0xA1] = 485
    device.server_id = b"pump\xff"
    device.own[bytes.fromhex("42")] = bytes.fromhex("42")  # a PZEM-004T resets its energy
    device.own[bytes.fromhex("6401020304")] = bytes.fromhex("64") + bytes(range(40))
    device.own[bytes.fromhex("6501020304")] = bytes.fromhex("E504")
    return device


def frame(pdu: str, node: int = 1) -> str:
    data = bytes([node]) + bytes.fromhex(pdu)
    return "< " + (data + crc(data)).hex(" ").upper()


READS = [
    ("03 00 A1 00 01", "03 02 01 E5", "node 1: response, unknown register (0x00A1) = 0x01E5"),
    ("030 0A10001", None, None),
    ("0300A10001", "03 02 01 E5", "node 1: response, unknown register (0x00A1) = 0x01E5"),
    ("04 0005 0002", "04 04 10 05 10 06", None),
    ("11", "11 05 70 75 6D 70 FF", None),
]


@scene("pty", "tcp", "mbap")
def reads(tool: Tool, scheme: str):
    """Functions that only read are sent without a question."""
    device = meter()
    with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
        name = port if scheme == "pty" else port.name
        for asked, response, words in READS:
            tool.run(f"send {name} raw {asked} {WAIT}")
            if response is None:
                tool.status_is(f"{scheme}: half a byte: {asked}", 2)
                continue
            tool.check(f"{scheme}: {asked}", tool.last.status == 0 and tool.last.lines[0] == frame(response))
            tool.is_equal(f"{scheme}: in two lines", len(tool.last.lines), 2)
            if words:
                tool.is_equal(f"{scheme}: in words", tool.last.lines[1], words)
        tool.fails(f"{scheme}: an exception", f"send {name} raw 03 01 00 00 01 {WAIT}", 1,
                   "refused, exception 2 (illegal data address)")
        sent = [pdu.hex() for pdu in device.requests]
        tool.is_equal(f"{scheme}: each request is sent once", sent,
                      ["0300a10001", "0300a10001", "0400050002", "11", "0301000001"])


@scene("pty", "tcp", "mbap")
def own_functions(tool: Tool, scheme: str):
    """Responses whose length nothing tells."""
    device = meter()
    with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
        name = port if scheme == "pty" else port.name
        tool.says(f"{scheme}: a response without data", f"send {name} raw:1 42 --yes {WAIT}", "< 01 42 80 11",
                  "node 1: valid frame of function 42h (user-defined), no data")
        tool.is_equal(f"{scheme}: it is sent once", device.requests.count(b"\x42"), 1)
        tool.run(f"send {name} raw 64 01 02 03 04 --yes {WAIT}")
        tool.check(f"{scheme}: a long one", tool.last.lines[0] == frame("64" + bytes(range(40)).hex()))
        tool.status_is(f"{scheme}: status 0", 0)
        tool.run(f"send {name} raw 65 01 02 03 04 --yes {WAIT}")
        tool.status_is(f"{scheme}: an exception of it", 1)
        tool.err_has(f"{scheme}: by its number", "refused, exception 4 (server device failure)")
        tool.is_equal(f"{scheme}: prints nothing", tool.last.out, "")


@scene()
def consent(tool: Tool):
    device = meter()
    with on_terminal(device) as port:
        tool.run(f"send {port} raw 42 {WAIT}", stdin="yes\n")
        tool.status_is("another word is no consent", 1)
        tool.err_has("says why it asks", "warning: function 42h may write, and it is sent as it is: who knows what it moves")
        tool.err_has("and what is left", "not confirmed, nothing was sent; --yes does it without a question")
        tool.is_equal("nothing is sent", device.requests, [])
        tool.run(f"send {port} raw 42 {WAIT}", stdin="send\n")
        tool.status_is("typed consent", 0)
        for asked in ["05 00 01 FF 00", "06 00 01 00 01", "10 00 01 00 01 02 00 01", "17 00 01 00 01 00 01 00 01 02 00 01",
                      "08 00 01 00 00", "2B 0D 00"]:
            device.requests.clear()
            tool.run(f"send {port} raw {asked} --timeout 100")
            tool.check(f"asks: {asked}", tool.last.status == 1 and "Type send" in tool.last.err and not device.requests)


@scene()
def echoes(tool: Tool):
    """A response that repeats its request is told from an echo by a read."""
    device = meter()
    with on_terminal(device) as port:
        tool.run(f"send {port} raw 42 --yes {WAIT}")
        tool.is_equal("a read follows", [pdu[0] for pdu in device.requests], [0x42, 3])
        device.requests.clear()
        tool.run(f"send {port} raw 42 --yes --echo off {WAIT}")
        tool.check("--echo off needs none", tool.last.status == 0 and device.requests == [b"\x42"])
        device.own[bytes.fromhex("0300000001")] = b""
        tool.run(f"send {port} raw 42 --yes --timeout 200 --retries 1")
        tool.check("silence is no echo", tool.last.status == 0 and tool.last.lines[0] == "< 01 42 80 11")
        tool.is_equal("a read is repeated, the request is not", [pdu[0] for pdu in device.requests[-3:]], [0x42, 3, 3])
        device.own.pop(bytes.fromhex("0300000001"))
        device.pause = 0.01
        tool.run(f"send {port} raw 64 01 02 03 04 --yes --inter-byte 1000 {WAIT}")
        tool.check("a pause inside a response", len(tool.last.lines) == 2 and len(tool.last.lines[0]) == 2 + 44 * 3 - 1)
        device.pause = 0
        tool.run(f"send {port} raw 06 00 01 00 07 --yes {WAIT}")
        tool.check("a write", tool.last.status == 0 and device.holding[1] == 7)
    device.own.clear()  # it ignores what it does not know, and the adapter returns it
    device.own[b"\x42"] = b""
    device.own[bytes.fromhex("0300000001")] = b""
    with on_terminal(device, echoes=True) as port:
        tool.run(f"send {port} raw 42 --yes --timeout 300 --retries 0")
        tool.status_is("an echo is no response", 1)
        tool.err_has("and named", "what came is the request's own echo: try --echo on")
        device.own = {b"\x42": b"\x42"}
        tool.run(f"send {port} raw 42 --yes --echo on {WAIT}")
        tool.check("behind it the response", tool.last.status == 0 and tool.last.lines[0] == "< 01 42 80 11")


@scene()
def failures(tool: Tool):
    device = meter()
    device.own[b"\x42"] = b""
    with on_terminal(device) as port:
        tool.run(f"send {port} raw 42 --yes --timeout 200")
        tool.status_is("no response", 1)
        tool.check("what is unknown then is said last", tool.last.err_lines[-1] == "servobus: unknown, no response")
        tool.fails("no response to a read", f"send {port} raw:2 03 00 00 00 01 --timeout 200", 1, "no response")
    many = " ".join(["42"] * 254)
    for name, words, text in [
        ("no bytes", "raw", "no bytes: a request begins with its function code"),
        ("no device", "", "send takes PORT DEVICE[:NODE] and the bytes of a request in hex"),
        ("no hex", "raw 4x", "'4x' is no bytes in hex"),
        ("half a byte", "raw 4", "'4' is no bytes in hex"),
        ("too many", f"raw {many}", "254 bytes are too many: a request has at most 253"),
        ("function 0", "raw 00", "function 00h is none of a request: these are 01h to 7Fh"),
        ("function 80h", "raw 83 02", "function 83h is none of a request"),
        ("a read that is cut", "raw 03 00 A1", "no request of function 03h is so"),
        ("a broadcast", "raw:0 42", "on a serial line 0 is a broadcast, which no node responds to"),
        ("a node beyond", "zlac8015d:200 42", "'200' is no node address of zlac8015d"),
    ]:
        tool.fails(name, f"send {NOWHERE} {words}", 2, text)


@scene()
def peer(tool: Tool):
    """The device at the end of Modbus TCP itself."""
    device = meter()
    with Gateway(device, "mbap") as port:
        tool.run(f"send {port.name} raw:0 42 --yes {WAIT}")
        tool.check("unit 0", tool.last.status == 0 and port.units[0] == 0)


@scene()
def drive(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.run("send drive zlac8015d 03 20 A1 00 01")
        tool.check("rows have their names", tool.last.status == 0 and "bus_voltage" in tool.last.lines[1])
        tool.fails("exceptions their words", "send drive zlac8015d 03 10 00 00 01", 1, "refused, exception 2 (")


play_tool()
