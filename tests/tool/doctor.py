# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""doctor: what it says of the port, the line, and the devices on it; when it asks, and how it ends.

Which states of a drive refuse an enable is tested against the facades, in tests/run/tool/doctor_*.cpp.
"""
import csv
import math
import os
import re
import signal
import sys
import threading
import tty
from contextlib import ExitStack, contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, on_terminal
from doctor_runs import Doctor
from programs import lines_of, play_tool, scene, until
from terminal import Terminal
from troubled_line import Troubles, troubled_line

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "examples/servobus/README.md").read_text("utf-8")
IS_WINE = bool(os.environ.get("ON_WINE"))


def plain(text: str) -> list[str]:
    """Times differ from run to run."""
    lines = lines_of(re.sub(r"[0-9]+\.[0-9]", "0.0", text).replace("; 2000 ms are", "; 100 ms are"))
    return [line for line in lines if " in a program: " not in line]  # a busy machine responds late


@scene()
def as_the_page_shows(tool: Doctor):
    """The runs in the tool's README."""
    shown = re.findall(r"(?m)^    \$ servobus (doctor drive .*)\n((?:    [^$].*\n)+)", PAGE)
    tool.check("the page has two runs", len(shown) == 2, shown)
    for command, output in shown:
        with tool.simulated("zlac8015d"):
            if "--period" in command:
                tool.run("write drive zlac8015d input_polarity=x0 host_timeout=100 right_max_current=12.5 --yes")
            tool.run(command)
            wanted = plain(re.sub("(?m)^    ", "", output))
            # The option that only tests give stands in the commands.
            tool.is_equal(f"the page's {command}", plain(tool.last.out.replace(" --timeout 2000", "")), wanted)


@scene()
def consent(tool: Doctor):
    with tool.simulated("zlac8015d"):
        tool.run("write drive zlac8015d mode_of_operation=velocity control_word=enable --yes")
        tool.run("doctor drive zlac8015d")
        tool.status_is("an enabled drive: without consent status 1", 1)
        tool.err_has("and it says why it asks", "each request feeds its watchdog")
        tool.err_has("and that it has stopped", "not confirmed, nothing more was read")
        tool.out_is("and nothing is printed")
        tool.run("doctor drive zlac8015d", stdin="read\n")
        tool.status_is("typed consent", 0)
        tool.finds("and it goes on", "status_word=left_locked")
        with Terminal([tool.path, "doctor", "drive", "zlac8015d", "--timeout", "2000"], tool.folder) as terminal:
            tool.check("the question", terminal.shows("Type read to go on"))
            terminal.type("no\n")
            terminal.wait()
            tool.check("any other word is none", terminal.status == 1 and "not confirmed" in terminal.shown)
        tool.run("write drive zlac8015d control_word=stop mode_of_operation=undefined")
        tool.run("doctor drive zlac8015d")
        tool.err_lacks("a drive that is not enabled is not asked about", "watchdog")
        tool.status_is("and status 0", 0)


# The line


@scene()
def no_response(tool: Doctor):
    with tool.simulated("zlac8015d"):
        tool.run("doctor drive zlac8015d:9 --timeout 30 --retries 0")
        tool.status_is("no response: status 1", 1)
        tool.finds("no response: what to try", "refused", "no response, node 9 at 115200 8N1: not a single byte",
                   "A and B", "servobus scan drive")
        tool.out_has("and the sum", "zlac8015d:9: 1 finding refuses an enable")


@scene()
def local_echo(tool: Doctor):
    with tool.simulated("zlac8015d --echo on"):
        tool.run("doctor drive zlac8015d:1")
        tool.status_is("an adapter that echoes: status 1", 1)
        tool.finds("an adapter that echoes: what came is its own echo", "refused", "the request's own echo",
                   "-> servobus doctor drive zlac8015d:1 --echo on --timeout 2000")
        # A busy machine may return an echo too late for one of the reads.
        until(lambda: tool.run("doctor drive zlac8015d:1 --echo on").status == 0 and "30 of 30 reads" in tool.last.out)
        tool.status_is("and with --echo on status 0", 0)
        tool.out_has("and its responses have a time", "30 of 30 reads")
    with tool.simulated("zlac8015d"):
        tool.run("doctor drive zlac8015d --echo on")
        tool.finds("no echo where there should be one", "refused", "did not come back",
                   "-> servobus doctor drive zlac8015d:1 --timeout 2000")
        tool.check("and not with the same option", not re.search("-> .*--echo", tool.last.out), tool.found())


@scene(
    ("noise", "55 55 55 55 55 55 55", "none a response of node 1", "another rate or format"),
    ("a response that is damaged", "01 03 02 00 00 11 22", "CRC", "another rate or format"),
    ("another node's response", "02 03 02 00 00 FC 44", "none a response of node 1", "two devices at one address"),
)
def garbled(tool: Doctor, name: str, response: str, what: str, act: str):
    with terminal_that_says(bytes.fromhex(response)) as port:
        tool.run(f"doctor {port} zlac8015d --timeout 100 --retries 0")
    tool.status_is(f"{name}: status 1", 1)
    tool.finds(name, "refused", what, act, f"servobus scan {port}")


@contextmanager
def terminal_that_says(response: bytes):
    """Gives the path of a pseudo-terminal on which each request has this response."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)

    def serve():
        try:
            while os.read(ours, 512):
                os.write(ours, response)
        except OSError:  # it is closed
            pass

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield os.ttyname(theirs)
    finally:
        os.close(theirs)


@scene()
def another_device(tool: Doctor):
    with on_terminal(Device()) as port:
        tool.run(f"doctor {port} zlac8015d --timeout 2000")
    tool.status_is("a device that refuses: status 1", 1)
    tool.finds("a device that refuses is perhaps another one", "refused", "exception 2",
               "another device than zlac8015d", f"servobus scan {port}")


@scene(
    ("yako-closed-loop", "yako-open-loop"), ("yako-open-loop", "yako-closed-loop"), ("zlac8015d", "c630s"),
    ("c630s", "zlac8015d"), ("yako-open-loop", "c630s"), ("c630s", "yako-closed-loop"), ("zlac8015d", "yako-open-loop"),
)
def another_drive(tool: Doctor, is_there: str, named: str):
    """It has the name of another drive: doctor says which it perhaps is, and what to ask instead."""
    with tool.simulated(is_there):
        tool.run(f"doctor drive {named}")
        tool.status_is(f"{named}: status 1", 1)
        tool.finds(f"{named}: perhaps a {is_there}", "refused", f"perhaps it is a {is_there}, not a {named}",
                   f"-> servobus doctor drive {is_there}:1 --timeout 2000")
        tool.is_equal(f"{named}: and nothing else", len(tool.findings()), 1)
        again = tool.findings()[0].partition("-> servobus ")[2]
        tool.run(again)
        tool.check(f"{is_there}: and that is so", "perhaps it is" not in tool.last.out, tool.found())


class Wheels(Device):
    """A ZLAC8015D as far as its registers are concerned: some of them are missing."""

    def __init__(self, *missing: int):
        super().__init__()
        self.words = {0x2000: 1000, 0x2001: 1, 0x2002: 2, 0x2008: 1000, 0x201E: 800, 0x2022: 1, 0x20A3: 0x0101}
        for motor in (0x2030, 0x2060):
            self.words |= {motor: 1024, motor + 3: 150, motor + 4: 300, motor + 0x0C: 500, motor + 0x0F: 100, motor + 0x16: 800}
        self.missing = missing

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        first, count = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        if pdu[0] != 3 or any(first <= one < first + count for one in self.missing):
            return bytes([pdu[0] | 0x80, 2])
        words = [self.words.get(first + i, 0) for i in range(count)]
        return bytes([3, 2 * count]) + b"".join(word.to_bytes(2, "big") for word in words)


def defaults(tool: Doctor) -> dict[int, int]:
    """What the map says that registers hold from the factory; of the others the lowest value."""
    rows = list(csv.DictReader(tool.run("map zlac8015d").lines))
    return {int(row["address"], 16): int(row["default"] or row["min"] or 0) & 0xFFFF for row in rows if row["words"] == "1"}


@scene()
def foreign_registers(tool: Doctor):
    """A device that has all registers, and holds in them what the drive cannot."""
    for name, word in [("0", 0), ("1", 1), ("65535", 65535)]:
        device = Wheels()
        device.words = dict.fromkeys(range(0x2000, 0x2100), word)
        with on_terminal(device) as port:
            tool.run(f"doctor {port} zlac8015d --timeout 2000 --yes")
        tool.is_equal(f"all hold {name}: one finding", len(tool.findings()), 1)
        tool.finds(f"all hold {name}", "refused", " registers hold the same word: it is no zlac8015d -> servobus scan")
        tool.status_is(f"all hold {name}: status 1", 1)
    device = Wheels()  # its bytes are exchanged
    device.words = {at: word >> 8 | (word & 0xFF) << 8 for at, word in (defaults(tool) | device.words).items()}
    with on_terminal(device) as port:
        tool.run(f"doctor {port} zlac8015d --timeout 2000 --yes")
    tool.is_equal("exchanged bytes: one finding", len(tool.findings()), 1)
    tool.finds("exchanged bytes", "refused", "registers hold what a zlac8015d does not take: it is another device, or its bytes")


@scene()
def unread_registers(tool: Doctor):
    for missing, status, line, total in [
        ((), 0, "", "nothing refuses an enable"),
        ((0x200C,), 0, "parking_mode: refused, exception 2 (illegal data address)", "nothing refuses an enable; "
                                                                                   "1 finding matters"),
        ((0x2016,), 1, "input_polarity: refused, exception 2 (illegal data address), which decides whether an enable is "
                       "refused", "1 register that decides could not be read"),
        ((0x2003, 0x2022), 1, "speed_resolution: refused", "2 registers that decide could not be read"),
    ]:
        device = Wheels(*missing)
        device.words = defaults(tool) | device.words
        with on_terminal(device) as port:
            tool.run(f"doctor {port} zlac8015d --timeout 2000")
        name = "without " + (", ".join(f"{one:04X}h" for one in missing) or "nothing")
        tool.status_is(f"{name}: status {status}", status)
        tool.is_equal(f"{name}: the sum", tool.last.lines[-1], f"zlac8015d:1: {total}")
        if line:
            tool.finds(f"{name}: the register is named", "unread", line)
        tool.is_equal(f"{name}: and no other", len(tool.findings()), len(missing))
        tool.is_equal(f"{name}: it only reads", {pdu[0] for pdu in device.requests}, {3})


@scene()
def interrupted(tool: Doctor):
    device = Wheels()
    device.delays = [0.3] * 100
    with on_terminal(device) as port:
        program = tool.start(f"doctor {port} zlac8015d --timeout 2000")
        until(lambda: len(device.requests) > 13)  # the reads that take the time of responses are over
        tool.ends(program, signal.SIGINT)
        tool.status_is("SIGINT: status 1", 1)
        tool.is_equal("and it says so", tool.last.err, "servobus: interrupted\n")
        tool.check("and has no sum", "an enable" not in tool.last.out)
        device.delays = []


@scene()
def late_responses(tool: Doctor):
    """A device that is late in one of its responses, and near the limit in another."""
    tool.write("meter.csv", "address,name\n1,one\n")
    device = Device()
    device.delays = [0, 0, 0.6]
    with on_terminal(device) as port:
        tool.run(f"doctor {port} meter.csv --timeout 300")
        tool.finds("a response that does not come in time", "matters", "1 of 30 responses began after the 300 ms that are allowed",
                   f"servobus doctor {port} meter.csv:1 --timeout ")
        device.delays = [0, 0, 0, 0.3]
        tool.run(f"doctor {port} meter.csv --timeout 500")
        tool.finds("a response that is nearly late", "matters", "of the 500 ms that are allowed: some will be late")
        tool.status_is("and it is no refusal", 0)
        device.delays = [0, 0, 0, 0.8]
        tool.run(f"doctor {port} meter.csv --timeout 4000")
        tool.finds("one that is later than all others", "matters", "a response began after ", "beyond the 4000 ms that are allowed")


def limits_for(most: float) -> set[int]:
    """The response limits that follow from the longest time as it is printed, with a decimal."""
    times = [math.ceil(most - 0.05), math.ceil(most + 0.05)]
    return {math.ceil(max(30, 2 * ms, ms + 16) / 10) * 10 for ms in times}


@scene(
    ("yako-closed-loop", "yako::closed_loop::device", 100, 0),
    ("yako-open-loop", "yako::open_loop::device", 100, 0),
    ("c630s", "c630s::device", 100, 0),
    ("zlac8015d", "zlac8015d::device", 32, 0),
    ("meter.csv", "device", 100, 0.06),
    ("zlac8015d", "zlac8015d::device", 32, 0.03),
)
def limit_in_a_program(tool: Doctor, device: str, type_name: str, usual: int, delay: float):
    """The line of code that states a response limit, where that of the profile does not fit what was measured."""
    with ExitStack() as stack:
        port = "drive"
        if device == "meter.csv":
            tool.write(device, "address,name\n1,one\n")
            slow = Device()
            slow.delays = [delay] * 100
            port = stack.enter_context(on_terminal(slow))
        else:
            stack.enter_context(tool.simulated(device))
            if delay:
                port = stack.enter_context(troubled_line([tool.folder / "drive"], Troubles(delay=delay), 1))
        tool.run(f"doctor {port} {device}:1 --timeout 2000")
    measured = re.search(r"([0-9.]+) ms \(least, median, most\)", tool.last.out)
    tool.check(f"{device}, {delay}: it measures", measured, tool.found())
    if not measured:
        return
    stated = re.findall(r"(?m)^line +in a program: (.*)$", tool.last.out)
    wanted = ["" if usual / 2 < ms <= usual else
              f"responds_within(node<{type_name}>{{1}}, milliseconds({ms})) waits {ms} ms for a response; by default it is {usual} ms"
              for ms in limits_for(float(measured[1]))]
    tool.check(f"{device}, {delay}: the code that states the limit", "".join(stated) in wanted, f"{wanted}\n{tool.found()}")
    if delay:
        tool.check(f"{device}, {delay}: and a slow one has such a line", len(stated) == 1, tool.found())


@scene()
def period(tool: Doctor):
    with tool.simulated("zlac8015d"):
        tool.run("doctor drive zlac8015d")
        tool.out_has("how long a cycle takes", "a setpoint and a read of the feedback take")
        tool.run("doctor drive zlac8015d --period 1")
        tool.finds("a period that is too short", "matters", "a period of 1 ms is too short", "a longer period")
        tool.run("doctor drive zlac8015d --period 5000")
        tool.is_equal("a long one is none", tool.findings(), [])


@scene()
def others_on_the_port(tool: Doctor):
    if IS_WINE:
        return tool.say("left out: Windows does not tell who has a port")
    with tool.simulated("zlac8015d"):
        watcher = tool.start("watch drive zlac8015d bus_voltage --interval 10")
        until(lambda: watcher.out)
        tool.run("doctor drive zlac8015d")
        tool.status_is("another program has the port: status 1", 1)
        tool.err_has("and which", f"another program uses it: {Path(tool.path).name[:15]} (process {watcher.pid})")
        tool.ends(watcher, signal.SIGINT)
        other = tool.start([], program=["sh", "-c", "exec sleep 100 <drive"])
        until(lambda: Path(f"/proc/{other.pid}/comm").read_text() == "sleep\n")
        tool.run("doctor drive zlac8015d")
        tool.status_is("a program without a lock on the port", 0)
        tool.finds("and which", "matters", f"is open in sleep (process {other.pid}) too", f"kill {other.pid}")
        tool.ends(other, signal.SIGKILL)
        tool.run("doctor drive zlac8015d")
        tool.is_equal("and without it nothing is found", tool.findings(), [])


# Several devices


@scene()
def several_devices(tool: Doctor):
    with tool.simulated("zlac8015d --baud 57600"):
        tool.run("doctor drive zlac8015d:1 c630s:2 yako-closed-loop:3 --timeout 50 --retries 0")
    tool.status_is("no rate of all: status 1", 1)
    tool.out_has("a ZLAC8015D, a C630S and a stepper share a rate",
                 "line     zlac8015d:1: 115200 8N1 from the factory, 38400 8N1 on a line with the others: "
                 "rs485_baud_rate=38400_Bd, then save, then switch it off and on")
    tool.out_has("and what the next one needs", "line     c630s:2: 57600 8N2 from the factory, 38400 8N1 on a line "
                 "with the others: rs485_baud_rate=38400_Bd data_format=8N1")
    tool.out_has("and each is asked", "no response, node 2 at 38400 8N1")
    tool.write("slow.csv", "# baud = 31250\naddress,name\n1,one\n")
    tool.run("doctor drive zlac8015d:1 slow.csv:2")
    tool.status_is("no rate in common: status 1", 1)
    tool.out_is("and nothing is opened", "refused  these devices have no rate and format in common: zlac8015d:1 has "
                "115200 8N1, slow.csv:2 has 31250 8N1 -> put them on lines of their own")
    tool.write("meter.csv", "address,name\n1,one\n")
    with Gateway(Device(), "mbap") as gateway:
        tool.run(f"doctor {gateway.name} meter.csv:1 meter.csv:2")
        tool.status_is("two that respond: status 0", 0)
        tool.out_has("each has its sum", "meter.csv:1: nothing found")
        tool.out_has("each has its sum", "meter.csv:2: nothing found")
        tool.out_has("a cycle is of both", "for all devices")


# A device from a file


@scene()
def device_of_a_file(tool: Doctor):
    tool.write("meter.csv", "address,name,type,access,scale,unit,min,max,default,table\n"
               "1,good,u16,ro,0.1,V,,,,\n"
               "2,changed,u16,rw,,,0,100,7,\n"
               "3,beyond,u16,rw,0.1,A,0,100,50,\n"
               "4,far,i16,ro,,,-5,5,,\n"
               "300,missing,u16,ro,,,,,,\n"
               "5,usual,u16,rw,,,0,100,9,\n"
               "6,hidden,u16,wo,,,,,,\n"
               "10,pump,bool,rw,,,,,0,coil\n"
               "4,level,u16,ro,,,,,,input\n")
    device = Device()
    device.holding[1:6] = [2300, 8, 101, 65000, 9]
    device.coils[10] = True
    with on_terminal(device) as port:
        tool.run(f"doctor {port} meter.csv --timeout 2000")
        tool.status_is("a device from a file: status 0", 0)
        tool.finds("a value outside its range", "matters", "beyond=10.1 A: outside 0.0 A .. 10.0 A",
                   "servobus write", "meter.csv:1 beyond=5.0")
        tool.finds("and one that can only be read", "matters", "far=-536: outside -5 .. 5")
        tool.finds("a row that it does not give", "unread", "missing: refused, exception 2")
        tool.finds("a value that was changed", "differs", "changed=8: the default is 7")
        tool.finds("a coil that was changed", "differs", "pump=1: the default is 0")
        tool.is_equal("and no other", len(tool.findings()), 5)
        tool.out_has("and the sum", "meter.csv:1: 3 findings matter; 2 registers differ from their defaults")
        device.holding[3], device.holding[4] = 50, 0
        tool.write("timer.csv", "address,name,access,default\n2,changed,rw,7\n3,usual,rw,50\n")
        tool.run(f"doctor {port} timer.csv --timeout 2000")
        tool.out_has("one alone is in the sum", "timer.csv:1: 1 register differs from its default\n")
        tool.check("which is not nothing", "nothing found" not in tool.last.out, tool.found())
        tool.is_equal("it only reads", {pdu[0] for pdu in device.requests} <= {1, 2, 3, 4}, True)
        tool.run(f"doctor {port} meter.csv:9 --timeout 50 --retries 0")
        tool.status_is("no response: status 1", 1)
        tool.finds("and what to try", "refused", "no response, node 9 at 9600 8N1")


@scene()
def wrong_words(tool: Doctor):
    for name, words, text in [
        ("no device", "doctor drive", "doctor takes PORT DEVICE"),
        ("no map", "doctor drive raw:3", "needs a device with a map, not raw"),
        ("one node for two", "doctor drive zlac8015d c630s", "two devices at node 1"),
        ("no such device", "doctor drive zlac", "unknown device"),
        ("no period", "doctor drive zlac8015d --period 0", "--period takes a whole number"),
        ("a gateway with a rate", "doctor tcp://127.0.0.1:1 zlac8015d --baud 9600", "the gateway sets rate"),
    ]:
        tool.fails(name, words, 2, text)
    tool.fails("no such port", "doctor /dev/no-such-port zlac8015d", 1, "there is no such port")


play_tool(Doctor)
