# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""doctor: what it finds of each drive, and the commands that it names, which are typed as they are printed.

That each row's command mends its finding is tested in tests/run/tool/doctor_*.cpp, with every state of a drive.
"""
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from doctor_runs import Doctor
from programs import play_tool, scene, until
from tapped_line import TappedLine

ROOT = Path(__file__).resolve().parents[2]

# What a write brings about, the register in front of the finding, and the status.
FOUND = {
    "zlac8015d": [
        ("input_polarity=x0", "x0_function", 1), ("input_polarity=x1 x1_function=9", "x1_function", 1),
        ("speed_resolution=10", "speed_resolution", 0), ("host_timeout=20", "host_timeout", 0),
        ("host_timeout=30000", "host_timeout", 0), ("parking_mode=on", "parking_mode", 0),
        ("right_encoder_lines=4096", "left_encoder_lines", 0),
        ("left_acceleration_time=100", "left_acceleration_time", 0), ("right_quick_stop_time=300", "left_quick_stop_time", 0),
        ("left_pole_pairs=10", "left_pole_pairs", 0), ("right_speed_kp=0", "right_speed_kp", 0),
        ("left_position_kp=0", "left_position_kp", 0),
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
        ("eeprom_update=on", "eeprom_update", 1), ("position_loop_gain=0", "position_loop_gain", 1),
        ("second_position_loop_gain=0 gain_switching_condition=1", "second_position_loop_gain", 1),
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


@scene()
def map_of_another_device(tool: Doctor):
    """A device that refuses most rows of a file is another one: one line, whatever the other rows hold."""
    with tool.simulated("zlac8015d"):
        tool.write("other.csv", tool.run("map yako-closed-loop --profile").out)
        rows = sum(",wo," not in row for row in tool.lines("other.csv") if row.startswith("0x"))
        tool.run("doctor drive other.csv:1")
        tool.status_is("the map of another drive: status 1", 1)
        tool.is_equal("one finding", len(tool.findings()), 1)
        tool.finds("with counts, and what it perhaps is", "refused", f" of {rows} rows of other.csv are refused (exception 2)",
                   "perhaps it is a zlac8015d, not what other.csv describes", "servobus doctor drive zlac8015d:1")
        tool.is_equal("and the sum", tool.last.lines[-1], "other.csv:1: 1 finding keeps it from being used")
        good = "0x2000,one\n0x2001,two\n"
        for bad, status, found in [("1,three\n2,four\n", 0, ["unread   three: ", "unread   four: "]),
                                   ("1,three\n2,four\n3,five\n", 1, ["refused  3 of 5 rows of some.csv are refused (exception 2)"])]:
            tool.write("some.csv", "address,name\n" + good + bad)
            tool.run("doctor drive some.csv:1")
            tool.status_is(f"{len(found)} lines: status {status}", status)
            tool.check(f"{len(found)} lines", len(tool.findings()) == len(found) and
                       all(map(str.startswith, tool.findings(), found)), tool.found())
    with on_terminal(Device()) as port:  # it is no drive that is known
        tool.write("some.csv", "address,name\n1,one\n300,two\n301,three\n")
        tool.run(f"doctor {port} some.csv --timeout 2000")
        tool.status_is("another device: status 1", 1)
        tool.finds("another device", "2 of 3 rows of some.csv are refused (exception 2): the file describes another device -> give")
        tool.write("some.csv", "address,name\n300,one\n")
        tool.run(f"doctor {port} some.csv --timeout 2000")
        tool.finds("a single row says nothing of a device", "unread   one: refused, exception 2")


@scene(("locked",), ("released",))
def asked_in_torque_mode(tool: Doctor, shaft: str):
    """Doctor asks while a ZLAC8015D is enabled in torque mode, however its shafts read then, and at no other time."""
    tool.write("switches.txt", f"servobus-findings format=1 device=zlac8015d\nin_torque_mode={shaft}\n")
    for before in ("", " control_word=stop"):
        with tool.simulated("zlac8015d --switches switches.txt"):
            tool.run(f"write drive zlac8015d mode_of_operation=torque{before} --yes")
            tool.run("doctor drive zlac8015d")
            tool.err_lacks(f"{shaft}: released{before}: nothing is enabled", "watchdog")
            tool.status_is(f"{shaft}: released{before}: status 0", 0)
            tool.run("write drive zlac8015d control_word=enable --yes")
            tool.run("doctor drive zlac8015d")
            tool.err_has(f"{shaft}: enabled{before}: it asks", "not confirmed, nothing more was read")
            tool.status_is(f"{shaft}: enabled{before}: status 1", 1)


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
    """Every request of doctor is a read: a listener on the line receives no other."""
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


play_tool(Doctor)
