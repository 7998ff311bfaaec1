# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Follows the page of the first hour to the letter, on simulated drives that were set up as the page finds them.

What a ```text block quotes must be printed by the commands of the block before it, in that order. `...` stands for the
rest of a line, and one number for another of the same kind. Commands that are not run are named, with the reason.
"""
import os
import re
import signal
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from hand_turned import WHEELS
from programs import Tool, play_tool, scene, until
from shared_wire import shared_wire

PAGE = (HERE.parents[1] / "examples/servobus/first_hour.md").read_text()
PORT = "/dev/ttyUSB0"
NOT_RUN = {"ls ": "there is no adapter here", "mkdir ": "the build compiles the program",
           "build/servo ": "it asks for a power cycle"}
# Where the drive of a command is. What names no drive is about the wheels.
LINKS = {"yako-closed-loop:1": "stepper_drive"}
# What a person types where a command asks.
TYPED = {"write": "write\n", "apply": "apply\n"}
WAIT = "--timeout 2000"


def blocks() -> list[tuple[str, list[str]]]:
    found = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return [(kind, text.splitlines()) for kind, text in found]


def machine_file() -> str:
    lines = PAGE.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("    servobus-machine"))
    last = next(i for i in range(first, len(lines)) if not lines[i])
    return "".join(line.strip() + "\n" for line in lines[first:last])


def is_like(quoted: str, line: str) -> bool:
    pattern = re.escape(re.sub(r"\d+(\.\d+)?", "0", quoted)).replace(re.escape("..."), ".*")
    return re.fullmatch(pattern + r"\s*", re.sub(r"\d+(\.\d+)?", "0", line)) is not None


# A pseudo-terminal has neither rate nor format.
def on_a_terminal(quoted: str) -> str:
    return quoted.replace("115200 8N1 1 zlac8015d", "- - 1 zlac8015d")


def quotes(tool: Tool, name: str, quoted: list[str], printed: str):
    lines = iter(printed.splitlines())
    for wanted in quoted:
        is_there = any(is_like(on_a_terminal(wanted), line) for line in lines)
        tool.check(f"{name}: {wanted[:60]}", is_there, printed)


def link_of(words: list[str]) -> str:
    return next((link for device, link in LINKS.items() if device in words), "drive")


# A motor turns the way of its target until its stop, and stands after it. The texts of the page do not tell 10 from 0.
def turns_as_told(tool: Tool, words: list[str], targets: dict[str, str]):
    last = tool.last.lines[-1] if tool.last.lines else ""
    for name in words[3:]:
        if not name.endswith("actual_speed"):
            continue
        target = targets.get(name.removesuffix("actual_speed"), "0")
        found = re.search(rf"\b{name}=(-?)([0-9.]+)", last)
        is_so = found is not None and (float(found[2]) == 0 if target == "0" else
                                       float(found[2]) > 0 and (found[1] == "-") == target.startswith("-"))
        tool.check(f"{name} is as target {target} orders", is_so, last)


def ordered(words: list[str], targets: dict[str, str]):
    """Notes what a write orders: a stop takes all targets back."""
    for word in words:
        name, _, value = word.partition("=")
        if value in ("stop", "quick_stop", "emergency_stop"):
            targets.clear()
        elif name.endswith("target_speed"):
            targets[name.removesuffix("target_speed")] = value
        elif name == "target_position":
            targets[""] = value


@scene()
def from_the_carton(tool: Tool):
    """A ZLAC8015D as from the factory, whose stop input was inverted, and a stepper; another program is the
    person's hand."""
    tool.write("machine.txt", machine_file())
    tool.write("wheels.csv", WHEELS)
    printed, played = "", 0
    targets: dict[str, str] = {}
    with tool.simulated("zlac8015d"), tool.simulated("yako-closed-loop", link="stepper_drive"), \
            tool.simulated("wheels.csv", link="by_hand"), shared_wire([tool.folder / "by_hand"], 2) as (shaft, hand):
        tool.run(f"write drive zlac8015d input_polarity=x0 host_timeout=100 {WAIT}")
        for kind, lines in blocks():
            if kind == "text":
                if printed:
                    quotes(tool, f"step {played}", lines, printed)
                continue
            printed = ""
            for line in lines:
                if any(line.startswith(begin) for begin in NOT_RUN):
                    continue
                tool.check(f"{line[:40]}: is a command of the tool", line.startswith("servobus "), line)
                words = line.split()[1:]
                is_by_hand = words[0] == "turn"
                place = shaft if is_by_hand else link_of(words)
                words = [place if word == PORT else word for word in words]
                asked = list(words)
                if words[0] == "scan":
                    words += ["--timeout", "300"]
                else:
                    words += WAIT.split()
                if is_by_hand:
                    reads, writes = os.pipe()
                    with os.fdopen(reads) as stdin:
                        running = tool.start(words, stdin=stdin)
                        until(lambda: "press Enter" in running.err)
                        tool.run(f"write {hand} wheels.csv left={5 * 4096 - 970} --yes {WAIT}")
                        os.write(writes, b"\n")
                        os.close(writes)
                        tool.ends(running)
                else:
                    if words[0] in ("doctor", "apply"): # a person takes longer than wheels that stop
                        until(lambda: "=0.0" in tool.run(f"read drive zlac8015d left_actual_speed {WAIT}").out)
                    if words[0] == "write":
                        ordered(asked, targets)
                    tool.run(words, stdin=TYPED.get(words[0], ""))
                    if words[0] == "watch":
                        turns_as_told(tool, asked, targets)
                printed += tool.last.out
                played += 1
                is_refused = "refused " in tool.last.out
                tool.check(f"{line[:60]}: its status", tool.last.status == (1 if is_refused else 0), tool.found())
        tool.check("the page was played", played >= 25, str(played))
        tool.check("the backup has what the last owner had",
                   "host_timeout=100" in tool.read("owner.txt") and "input_polarity=1" in tool.read("owner.txt"))
        until(lambda: "=0.0" in tool.run(f"read drive zlac8015d left_actual_speed {WAIT}").out)
        tool.says("the wheels have stopped, and the drive keeps its file",
                  f"read drive zlac8015d left_actual_speed left_max_current host_timeout {WAIT}",
                  "left_actual_speed=0.0 r/min", "left_max_current=12.5 A", "host_timeout=1000 ms")


@scene()
def stops(tool: Tool):
    """The three stops of the page: without a question, and of a motor that turns."""
    commands = re.findall(r"^    servobus write /dev/ttyUSB0 (\S+) (\S+)", PAGE, re.MULTILINE)
    tool.check("there is one for each drive", len(commands) == 3, str(commands))
    for device, word in commands:
        kind = device.split(":")[0]
        with tool.simulated(kind, link=kind):
            tool.run(f"write {kind} {device} {word} {WAIT}")
            tool.check(f"{kind}: {word} asks nothing", tool.last.status == 0 and "Type" not in tool.last.err, tool.found())
    with tool.simulated("zlac8015d"):
        tool.run(f"write drive zlac8015d host_timeout=20000 mode_of_operation=velocity left_target_speed=10 control_word=enable --yes {WAIT}")
        until(lambda: "=10.0" in tool.run(f"read drive zlac8015d left_actual_speed {WAIT}").out)
        tool.run(f"write drive zlac8015d:1 control_word=quick_stop {WAIT}")
        stopped = until(lambda: "=0.0" in tool.run(f"read drive zlac8015d left_actual_speed {WAIT}").out)
        tool.check("and stops it", stopped)


@scene()
def stops_after_an_interrupt(tool: Tool):
    """`watch` holds the port, so that a stop is refused; after Ctrl-C there it stops the wheels."""
    stop = f"write drive zlac8015d:1 control_word=quick_stop {WAIT}"
    with tool.simulated("zlac8015d"):
        tool.run(f"write drive zlac8015d host_timeout=20000 mode_of_operation=velocity left_target_speed=10 control_word=enable --yes {WAIT}")
        watch = tool.start("watch drive zlac8015d:1 left_actual_speed --interval 100")
        tool.check("the wheel turns while it is watched", until(lambda: "=10.0" in watch.out), watch.out)
        tool.fails("a stop is refused meanwhile, with the page's words", stop, 1, "another program uses it")
        tool.ends(watch, signal.SIGINT)
        tool.run(stop)
        tool.status_is("after Ctrl-C it is done", 0)
        stopped = until(lambda: "=0.0" in tool.run(f"read drive zlac8015d left_actual_speed {WAIT}").out)
        tool.check("and the wheel stands", stopped)


@scene()
def a_released_stepper(tool: Tool):
    """It ignores a start until it is enabled."""
    start = f"write drive yako-closed-loop positioning_speed=20 target_position=2000 motion_command=start_position --yes {WAIT}"
    speed = f"read drive yako-closed-loop actual_speed {WAIT}"
    with tool.simulated("yako-closed-loop"):
        tool.run(f"write drive yako-closed-loop auxiliary_command=release --yes {WAIT}")
        tool.run(start)
        tool.check("a start is ignored", "=0 " in tool.run(speed).out, tool.found())
        tool.run(f"write drive yako-closed-loop auxiliary_command=enable --yes {WAIT}")
        tool.check("also after the enable", "=0 " in tool.run(speed).out, tool.found())
        tool.run(start)
        tool.check("the next one is not", until(lambda: "=20 " in tool.run(speed).out), tool.found())


play_tool()
