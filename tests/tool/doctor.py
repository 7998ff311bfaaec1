# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""doctor: its findings in the real tool, the commands that it names, and what it says of the port and the line.

Which states of a drive refuse an enable is tested against the facades, in tests/run/tool/doctor_*.cpp.
"""
import os
import re
import signal
import sys
import threading
import tty
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, on_terminal
from programs import Tool, lines_of, play_tool, scene, until
from tapped_line import TappedLine
from terminal import Terminal

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "examples/servobus/README.md").read_text("utf-8")
IS_WINE = bool(os.environ.get("ON_WINE"))


class Doctor(Tool):
    def findings(self) -> list[str]:
        return [line for line in self.last.lines if re.match("(refused|matters|unread|differs) ", line)]

    def finds(self, name: str, *parts: str):
        """A finding of the last run has all these parts."""
        is_there = any(all(part in line for part in parts) for line in self.findings())
        self.check(name, is_there, f"expected {parts}\n{self.found()}")


def plain(text: str) -> list[str]:
    """Times differ from run to run."""
    return lines_of(re.sub(r"[0-9]+\.[0-9]", "0.0", text).replace("of the 2000 ms", "of the 100 ms"))


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


# What a write brings about, the register in front of the finding, and the status.
FOUND = {
    "zlac8015d": [
        ("input_polarity=x0", "x0_function", 1), ("input_polarity=x1 x1_function=9", "x1_function", 1),
        ("speed_resolution=10", "speed_resolution", 0), ("host_timeout=20", "host_timeout", 0),
        ("host_timeout=30000", "host_timeout", 0), ("parking_mode=on", "parking_mode", 0),
        ("right_encoder_lines=4096", "left_encoder_lines", 0),
        ("left_acceleration_time=100", "left_acceleration_time", 0),
        ("left_target_speed=20", "left_target_speed", 0), ("right_target_torque=500", "right_target_torque", 0),
        ("left_brake=code_1", "left_brake", 0), ("shaft_at_power_on=locked", "shaft_at_power_on", 0),
        ("mode_of_operation=velocity control_word=enable", "status_word", 0),
        ("right_max_current=12.5", "right_rated_current", 0), ("right_max_current=10", "left_max_current", 0),
        ("left_max_speed=900 right_max_speed=900 max_motor_speed=300", "left_max_speed", 0),
        ("node_address=3", "node_address", 0),
    ],
    "yako-closed-loop": [
        ("pair_word_order=low_first", "pair_word_order", 0), ("speed_resolution=1", "speed_resolution", 0),
        ("x3_function=positive_limit", "x3_function", 0),
        ("input_polarity=0x0001 x0_function=motor_free", "x0_function", 1),
        ("input_polarity=0x0008 x3_function=stop", "x3_function", 0), ("holding_current=0", "holding_current", 0),
        ("closed_loop_max_current=0", "closed_loop_max_current", 0), ("base_current=0", "base_current", 0),
        ("jog_speed=60 motion_command=2", "status_word", 0), ("software_limits=1", "software_limits", 0),
        ("software_limits=1 positive_software_limit=-5 negative_software_limit=100", "software_limits", 0),
        ("input_polarity=x1", "x1_function", 0), ("over_travel_stop_mode=coast", "over_travel_stop_mode", 0),
    ],
    "yako-open-loop": [
        ("input_polarity=0x0040 x6_function=motor_free", "x6_function", 1), ("holding_current=0", "holding_current", 0),
        ("open_loop_max_current=0", "open_loop_max_current", 0),
    ],
    "c630s": [
        ("max_speed=0", "max_speed", 1), ("emergency_stop=1", "emergency_stop", 1),
        ("terminal_forcing=1", "terminal_forcing", 1), ("response_delay=60", "response_delay", 1),
        ("P0C-10=1", "virtual_inputs_at_power_on", 1), ("P03-00=3", "power_on_functions_1_to_16", 1),
        ("P0C-10=vdi1+vdi5", "virtual_inputs_at_power_on", 1),
        ("di3_logic=high_level", "di3_function", 1), ("di2_logic=high_level", "di2_function", 1),
        ("di1_logic=high_level", "di1_function", 1), ("di4_function=servo_on", "di4_function", 1),
        ("positive_internal_torque_limit=0", "positive_internal_torque_limit", 1),
        ("eeprom_update=on", "eeprom_update", 1),
    ],
}
# Writes whose command leaves something, and what undoes that.
UNDONE = {"software_limits=1 positive_software_limit=-5 negative_software_limit=100": "software_limits=disabled"}


def sentence(finding: str) -> str:
    """Why a finding matters, without the values and the command."""
    return finding.partition(": ")[2].partition(" -> ")[0]


@scene(*[(device,) for device in FOUND])
def found_and_mended(tool: Doctor, device: str):
    """Each finding by the register in front of it; its command is one that the tool accepts, and mends it."""
    usual = 1 if device == "c630s" else 0
    with tool.simulated(device):
        for write, register, status in FOUND[device]:
            tool.run(f"write drive {device} {write} --yes")
            tool.status_is(f"{device} {write}: is written", 0)
            tool.run(f"doctor drive {device} --yes")
            tool.status_is(f"{device} {write}: status {status}", status)
            word = "refused" if status > usual else "matters"
            found = [line for line in tool.findings() if re.match(rf"{word} +{register}=", line)]
            tool.check(f"{device} {write}: {word} {register}", found, tool.found())
            named = re.findall(r"servobus write \S+ \S+ (\S+(?: \S+)*?) --timeout", tool.last.out)
            raw = [one for one in named if re.search(r"=0x|\bP[0-9A-F]{2}-", one)]
            tool.is_equal(f"{device} {write}: registers and codes have names", raw, [])
            found = [line for line in found if "servobus write" in line]
            tool.check(f"{device} {write}: a command is named", found, tool.found())
            if not found:
                continue
            tool.run(found[0][found[0].index("write ", found[0].index("servobus write")):] + " --yes")
            tool.status_is(f"{device} {write}: its command is done", 0)
            is_there = lambda: any(sentence(found[0]) in line
                                   for line in tool.run(f"doctor drive {device} --yes").lines if register in line)
            tool.check(f"{device} {write}: and mends it", until(lambda: not is_there()), found[0])
            tool.status_is(f"{device} {write}: as before", usual)
            if write in UNDONE:
                tool.run(f"write drive {device} {UNDONE[write]} --yes")


@scene()
def listed_in_full(tool: Doctor):
    """A C630S that is not set up: the finding says how many registers differ, and names the command that lists them."""
    with tool.simulated("c630s"):
        tool.run("doctor drive c630s")
        tool.check("no register that differs has a line", not any(line.startswith("differs") for line in tool.findings()))
        named = re.search(r"(\d+) registers differ, listed by servobus (doctor \S+ \S+ --long)", tool.last.out)
        tool.check("the command that lists them is named", named, tool.found())
        if not named:
            return
        before = tool.last.lines[2:]
        tool.run(named[2])
        listed = [line for line in tool.findings() if line.startswith("differs")]
        tool.is_equal("as many are listed", len(set(listed)), int(named[1]))
        tool.check("each with its value and what it has to be",
                   all(re.fullmatch(r"differs  \w+=\w+ \(0x....\): has to be \w+ \(0x....\)", line) for line in listed), listed)
        tool.check("below their finding", listed == tool.findings()[1:1 + len(listed)] and "listed below" in tool.last.out)
        tool.is_equal("the others are the same", len(tool.last.lines[2:]) - len(listed), len(before))
        tool.run("write drive c630s di1_function=none")
        tool.run("doctor drive c630s")
        tool.out_has("one less once it is written", f"{int(named[1]) - 1} registers differ")


# Findings of a drive from its carton: the register in front, and why it would surprise its owner. The simulated steppers
# have no current, since the manual states none from the factory.
FACTORY = {
    "zlac8015d": [],
    "yako-closed-loop": [("over_travel_stop_mode", "so from the factory"), ("max_current", "from the factory")],
    "yako-open-loop": [("over_travel_stop_mode", "so from the factory"), ("max_current", "from the factory")],
    "c630s": [("virtual_inputs_enable", "not set up"), ("eeprom_update", "so from the factory")],
}


@scene(*[(device,) for device in FACTORY])
def from_the_carton(tool: Doctor, device: str):
    with tool.simulated(device):
        tool.run(f"doctor drive {device}")
        found = tool.findings()
        tool.check(f"{device}: what surprises", len(found) == len(FACTORY[device]) and
                   all(f" {register}=" in line and why in line for line, (register, why) in zip(found, FACTORY[device])),
                   tool.found())


@scene(("zlac8015d", "zlac8015d"), ("yako", "yako-closed-loop"), ("c630s", "c630s"))
def named_commands(tool: Doctor, table: str, device: str):
    """Each command that a table of checks names is one that the tool takes; a drive may refuse it in another state."""
    source = (ROOT / f"examples/servobus/doctor/{table}.hpp").read_text("utf-8")
    writes = sorted(set(re.findall(r'\.write = "([^"]+)"', source)))
    tool.check(f"{table}: there are some", len(writes) > 5, writes)
    with tool.simulated(device):
        for write in writes:
            tool.run(f"write drive {device} {write} --yes")
            tool.check(f"{table}: {write}", tool.last.status in (0, 1) and "unknown" not in tool.last.err, tool.found())


@scene(*[(device,) for device in FOUND])
def only_reads(tool: Doctor, device: str):
    """Every request of doctor is a read: a listener on the line hears no other."""
    with tool.simulated(device):
        tap = TappedLine.relay(tool.folder / "tap", tool.folder / "client", tool.folder / "drive")
        listener = tool.start(f"listen tap {device} --log capture --timeout 2000")
        until(lambda: tool.exists("capture"))
        tool.run(f"doctor client {device}")
        frames = lambda: [line for line in tool.lines("capture") if line[:2] in ("> ", "< ")]
        until(lambda: sum(len(bytes.fromhex(line[1:])) for line in frames()) == tap.carried)
        tool.ends(listener, signal.SIGINT)
        requests = [bytes.fromhex(line[1:]) for line in frames() if line[0] == ">"]
        tool.check(f"{device}: doctor asks", len(requests) > 15, len(requests))
        tool.is_equal(f"{device}: and only reads", {request[1] for request in requests}, {3})
        tap.close()


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
        until(lambda: tool.run("doctor drive zlac8015d:1 --echo on").status == 0)
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
            self.words |= {motor: 1024, motor + 3: 150, motor + 4: 300, motor + 0x16: 800}
        self.missing = missing

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        first, count = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        if pdu[0] != 3 or any(first <= one < first + count for one in self.missing):
            return bytes([pdu[0] | 0x80, 2])
        words = [self.words.get(first + i, 0) for i in range(count)]
        return bytes([3, 2 * count]) + b"".join(word.to_bytes(2, "big") for word in words)


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
        tool.finds("a response that does not come in time", "matters", "1 of 30 reads have no valid response (1: no response)")
        device.delays = [0, 0, 0, 0.3]
        tool.run(f"doctor {port} meter.csv --timeout 500")
        tool.finds("a response that is nearly late", "matters", "of the 500 ms that are allowed: some will be late")
        tool.status_is("and it is no refusal", 0)


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
        tool.out_has("and the sum", "meter.csv:1: 3 findings matter")
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
    tool.fails("no such port", "doctor /dev/no-such-port zlac8015d", 1, "No such file")


play_tool(Doctor)
