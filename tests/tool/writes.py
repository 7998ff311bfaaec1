# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What a device does with a write: it ignores it, takes it by another function, or answers nothing else."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from programs import Tool, play_tool, scene

METER = "address,name,type,access,flags,table\n16,limit,u16,rw,,\n17,start,u16,rw,trigger,\n18,secret,u16,wo,,\n" \
        "20,count,u32,rw,,\n3,pump,bool,rw,,coil\n"
WITHOUT_FLAGS = "address,name,type,access\n16,limit,u16,rw\n"


class Ignoring(Device):
    """Acknowledges each write, and executes none."""

    def response_to(self, pdu: bytes) -> bytes:
        if pdu[0] not in (5, 6, 15, 16):
            return super().response_to(pdu)
        self.requests.append(pdu)
        return pdu[:5]


class Deaf(Device):
    """Answers these functions alone."""

    def __init__(self, *functions: int):
        super().__init__()
        self.functions = functions

    def response_to(self, pdu: bytes) -> bytes:
        if pdu[0] in self.functions:
            return super().response_to(pdu)
        self.requests.append(pdu)
        return b""


class BlocksOnly(Device):
    """Takes a single register by 10h, and a single coil by 0Fh."""

    def response_to(self, pdu: bytes) -> bytes:
        return bytes([pdu[0] | 0x80, 1]) if pdu[0] in (5, 6) else super().response_to(pdu)


@scene()
def ignored(tool: Tool):
    """A device that acknowledges a write and does nothing is seen where the register can be read back."""
    tool.write("meter.csv", METER)
    device = Ignoring()
    with on_terminal(device) as port:
        for words, said in [
            ("limit=7", "limit: acknowledged, and the device holds 0: it ignored the write"),
            ("limit=7 limit=0", ""),
            ("limit=0", ""),
            ("count=70000", "count: acknowledged, and the device holds 0: it ignored the write"),
            ("pump=1", "pump: acknowledged, and the device holds off: it ignored the write"),
            ("limit=7 pump=1", "limit: acknowledged, and the device holds 0: it ignored the write; pump: "
                               "acknowledged, and the device holds off: it ignored the write"),
            ("start=7", ""), ("secret=7", ""),
        ]:
            tool.run(f"write {port} meter.csv {words} --yes --timeout 1000")
            lines = [line for line in tool.last.err_lines if "warning" not in line]
            tool.is_equal(f"{words}: what is said", lines, [f"servobus: {said}"] if said else [])
            tool.status_is(f"{words}: the status", 1 if said else 0)
        tool.write("plain.csv", WITHOUT_FLAGS)
        for words in ["plain.csv limit=7", "raw 16=7"]:
            tool.run(f"write {port} {words} --yes --timeout 1000")
            tool.err_has(f"{words}: both causes", "it ignored the write, or the register is a command that it clears")
            tool.status_is(f"{words}: and it may be right", 0)


@scene()
def read_back(tool: Tool):
    tool.write("meter.csv", METER)
    device = Device()
    with on_terminal(device) as port:
        tool.run(f"write {port} meter.csv limit=7 count=70000 pump=1 --yes --timeout 1000")
        tool.status_is("a device that executes them", 0)
        tool.err_lacks("has no remark", "acknowledged")
        device.delays = [0, 0, 0.6]  # a read that rules out an echo, the write, and the read after it
        tool.run(f"write {port} meter.csv limit=8 --yes --timeout 300 --retries 0")
        tool.status_is("no response to the read after a write: it is written", 0)
        tool.err_has("and some devices need a pause", "the device needs a pause after a write, --gap 8")


@scene()
def by_blocks(tool: Tool):
    device = BlocksOnly()
    with on_terminal(device) as port:
        for words, code in [("0x10=7", "10h"), ("coil:3=on", "0Fh")]:
            tool.run(f"write {port} raw {words} --yes --timeout 1000")
            tool.err_has(f"{words}: the refusal names the option", "refused, exception 1 (illegal function); for a device "
                         f"that takes function {code} alone: --blocks-only")
            tool.exits(f"{words}: which helps", f"write {port} raw {words} --yes --timeout 1000 --blocks-only", 0)
        tool.is_equal("10h", device.holding[0x10], 7)
        tool.is_equal("0Fh", device.coils[3], True)
        tool.exits("several are as before", f"write {port} raw 0x20:2=1,2 --yes --timeout 1000", 0)


@scene()
def no_read(tool: Tool):
    """A relay module that answers 05 and 06 alone."""
    device = Deaf(5, 6)
    with on_terminal(device) as port:
        tool.run(f"write {port} raw coil:3=on --yes --timeout 100 --retries 0")
        tool.err_has("a coil is read first: what had no response", ": not sent, no response to the read that goes before: it "
                     "rules out that the write's response is the request's own echo. --echo off says that this adapter")
        tool.is_equal("nothing was written", [pdu[0] for pdu in device.requests if pdu[0] > 4], [])
        tool.run(f"write {port} raw 0x10=7 --yes --timeout 100 --retries 0")
        tool.err_has("a register is read after it", "unknown, what came may be the request's own echo: --echo off says that "
                     "this adapter returns nothing")
        device.holding[0x10] = 0
        for words in ["coil:3=on", "0x10=7"]:
            tool.run(f"write {port} raw {words} --yes --timeout 100 --retries 0 --echo off")
            tool.status_is(f"{words}: with --echo off", 0)
        tool.is_equal("a coil", device.coils[3], True)
        tool.is_equal("a register", device.holding[0x10], 7)


play_tool()
