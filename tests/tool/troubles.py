# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Troubles that are planted on a line and in a drive: doctor or scan names each of them, and nothing that is not there.

Each alone, and in random pairs. SEEDS=10 plays them with ten seeds, 1 is usual.
"""
import os
import random
import re
import socket
import sys
import threading
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from programs import Tool, play_tool, scene
from troubled_line import Troubles, troubled_line

SEEDS = int(os.environ.get("SEEDS", "1"))
# What a busy computer adds to any line.
LATE = r"responses? began after|responses begin after up to|responses of node 1 came after"


@dataclass
class Trouble:
    """`says`: what names it in a finding of doctor; `scan_says`: in the output of scan, where that is another place."""

    says: str
    on_line: dict = field(default_factory=dict)
    in_drive: str = ""  # assignments of `servobus write`
    drive: str = "zlac8015d"
    ends_it: bool = False  # what the drive holds is not examined
    scan_says: str = ""
    also: str = ""  # a finding that may come with it


LINE = {
    "slow, 60 ms": Trouble(LATE, {"delay": 0.05}, scan_says="responds after|zlac8015d"),
    "slow, 75 ms": Trouble(LATE + ".* --timeout [2-9]", {"delay": 0.065}, scan_says="responds after .* --timeout [2-9]"),
    "slow, 145 ms": Trouble("responses began after the 100 ms that are allowed, .* --timeout [3-9]", {"delay": 0.13},
                            scan_says="responds after .* --timeout [3-9]"),
    "two drives at one address": Trouble("had two responses.*two devices have this address", {"second_after": 0.008},
                                         ends_it=True, scan_says="had two responses"),
    "an adapter that echoes": Trouble("the request's own echo comes before each response -> .*--echo on",
                                      {"is_echoing": True}, ends_it=True, scan_says="try --echo on"),
    "every third request is answered": Trouble("ha(ve|s) no response",
                                               {"answers_every": 3}),
    "a lossy line": Trouble("ha(ve|s) no response|it fails now and then", {"lost": 0.1, "damaged": 0.06}),
    "a byte each 30 ms": Trouble("came in .* ms while nothing was asked", {"byte_each": 0.03}, ends_it=True,
                                 also="ha(ve|s) no response|it fails now and then|bytes? came beside", scan_says="while nothing was asked"),
    "another master": Trouble("frames? came in .*first of node 7: another master or program", {"master_each": 0.06}, ends_it=True,
                              also="ha(ve|s) no response|it fails now and then|bytes? came beside", scan_says="first of node 7: another master"),
}
DRIVE = {
    "a stop input": Trouble("an emergency stop is active", in_drive="input_polarity=x0"),
    "a short watchdog": Trouble("host_timeout=100 ms: the drive stops when a single response is lost",
                                in_drive="host_timeout=100"),
    "unlike currents": Trouble("the wheels are unlike", in_drive="right_max_current=20 right_rated_current=10"),
    "no speed": Trouble("max_motor_speed|speed", in_drive="max_motor_speed=1"),
    "a gain of zero": Trouble("left_speed_kp=0: ", in_drive="left_speed_kp=0", also="the wheels are unlike"),
    "unlike pole pairs": Trouble("left_pole_pairs=15, right_pole_pairs=10", in_drive="right_pole_pairs=10"),
    "unlike ramps": Trouble("unlike ramps", in_drive="left_acceleration_time=200"),
}


@contextmanager
def played(tool: Tool, troubles: list[Trouble], seed: int):
    """Gives the port of a line with these troubles, and what was planted."""
    planted = Troubles()
    for t in troubles:
        for name, value in t.on_line.items():
            setattr(planted, name, value)
    with ExitStack() as stack:
        links = ["first"] + (["second"] if planted.second_after else [])
        for link in links:
            stack.enter_context(tool.simulated(troubles[0].drive, link=link))
        for t in troubles:
            if t.in_drive:
                tool.run(f"write first zlac8015d:1 {t.in_drive} --yes --timeout 2000")
                tool.check(f"{t.in_drive} is planted", tool.last.status == 0, tool.found())
        yield stack.enter_context(troubled_line([tool.folder / link for link in links], planted, seed)), planted


def findings(out: str) -> list[str]:
    return [line for line in out.splitlines() if re.match("(refused|matters|unread|differs) ", line)]


def judge(tool: Tool, names: list[str], troubles: list[Trouble], seed: int):
    what = " and ".join(names) + f", seed {seed}"
    with played(tool, troubles, seed) as (port, planted):
        tool.run(f"doctor {port} zlac8015d:1")
        found = findings(tool.last.out)
        is_hidden = any(t.ends_it for t in troubles)
        for name, t in zip(names, troubles):
            if t.in_drive and is_hidden:
                continue
            tool.check(f"{what}: doctor names {name}", any(re.search(t.says, line) for line in found), tool.found())
        allowed = "|".join([t.says for t in troubles] + [t.also for t in troubles if t.also] + [LATE])
        others = [line for line in found if not re.search(allowed, line)]
        tool.check(f"{what}: and nothing else", not others, "\n".join([*others, "", tool.found()]))
        for name, t in zip(names, troubles):
            for kind in t.on_line:
                tool.check(f"{what}: {kind} happened", planted.happened.get(kind, 0) > 0, planted.happened)
            if t.scan_says and len(troubles) == 1:
                tool.run(f"scan {port} --nodes 1-3")
                tool.check(f"{what}: scan names it", re.search(t.scan_says, tool.last.out + tool.last.err), tool.found())


ALL = {**LINE, **DRIVE}


@scene(*[(name, seed) for name in ALL for seed in range(SEEDS)])
def alone(tool: Tool, name: str, seed: int):
    judge(tool, [name], [ALL[name]], seed)


def pairs(seed: int) -> list[tuple[str, str]]:
    """Two that can be told from each other: of the line and in the drive, or of the line and not of one kind."""
    dice = random.Random(seed)
    both = [(a, b) for a in LINE for b in DRIVE]
    kinds = [{"slow, 60 ms", "slow, 75 ms", "slow, 145 ms"}, {"every third request is answered", "a lossy line"},
             {"a byte each 30 ms", "another master"}]
    of_line = [(a, b) for i, a in enumerate(LINE) for b in list(LINE)[i + 1 :]
               if not any({a, b} <= kind for kind in kinds) and not {a, b} & {"two drives at one address"}]
    return dice.sample(both, 10) + dice.sample(of_line, 10)


@scene(*[(pair, seed) for seed in range(SEEDS) for pair in pairs(seed)])
def in_pairs(tool: Tool, pair: tuple[str, str], seed: int):
    judge(tool, list(pair), [ALL[name] for name in pair], seed)


def found_alone(tool: Tool, name: str, command: str, says: str):
    """The command names it, and a doctor nothing else."""
    tool.run(command)
    tool.check(f"{name}: {command.split()[0]} names it", re.search(says, tool.last.out + tool.last.err), tool.found())
    if command.startswith("doctor"):
        others = [line for line in findings(tool.last.out) if not re.search(says + "|" + LATE, line)]
        tool.check(f"{name}: and nothing else", not others, tool.found())
    tool.status_is(f"{name}: status 1", 1)


SILENCE = "not a single byte came -> the supply, A and B swapped.*--timeout 500"


@scene()
def nobody(tool: Tool):
    """No drive at the address; an adapter that echoes makes it no other."""
    with tool.simulated("zlac8015d --node 9", link="first"):
        with troubled_line([tool.folder / "first"], Troubles()) as port:
            found_alone(tool, "nobody", f"doctor {port} zlac8015d:1", SILENCE)
            found_alone(tool, "nobody", f"scan {port} --nodes 1-3", "no device responds within 50 ms: a slower one needs "
                        "--timeout 500; else the supply, A and B swapped, or another rate, format or address")
            found_alone(tool, "nobody", f"read {port} zlac8015d:1 bus_voltage", "bus_voltage: no response$")
        with troubled_line([tool.folder / "first"], Troubles(is_echoing=True)) as port:
            found_alone(tool, "the echo alone", f"doctor {port} zlac8015d:1", "what came is the request's own echo, and no "
                        "response after it -> .*--echo on; if no response comes then, the supply, A and B swapped, or the node")
            found_alone(tool, "the echo alone, known", f"doctor {port} zlac8015d:1 --echo on",
                        "the request's own echo came, and not a single byte after it")
            found_alone(tool, "the echo alone", f"scan {port} --nodes 1-3", "the request's own echo: try --echo on")
            found_alone(tool, "the echo alone, known", f"scan {port} --nodes 1-3 --echo on", "no device responds within 50 ms")


@scene()
def foreign(tool: Tool):
    """Another drive than the one named, a meter, and a device that holds the same everywhere."""
    with tool.simulated("yako-closed-loop", link="first"):
        with troubled_line([tool.folder / "first"], Troubles()) as port:
            found_alone(tool, "another drive", f"doctor {port} zlac8015d:1",
                        "perhaps it is a yako-closed-loop, not a zlac8015d -> servobus doctor .* yako-closed-loop:1")
            tool.write("other.csv", tool.run("map yako-closed-loop --profile").out)
    with tool.simulated("zlac8015d", link="first"):
        with troubled_line([tool.folder / "first"], Troubles()) as port:
            found_alone(tool, "a foreign map", f"doctor {port} other.csv:1",
                        r"rows of other.csv are refused .*perhaps it is a zlac8015d")
    with on_terminal(Device()) as port:
        found_alone(tool, "a meter", f"doctor {port} zlac8015d:1", "another device than zlac8015d -> servobus scan")
        tool.run(f"scan {port} --nodes 1")
        tool.out_is("a meter: scan names no drive", "- - 1 unknown device")


@scene("closes", "is silent")
def gateway(tool: Tool, does: str):
    """It takes no further connection, or serves one client at a time: the connection is there, and not a byte comes."""
    server = socket.create_server(("127.0.0.1", 0))
    kept = []

    def serve():
        while True:
            try:
                one = server.accept()[0]
            except OSError:
                return
            if does == "closes":
                one.close()
            else:
                kept.append(one)

    threading.Thread(target=serve, daemon=True).start()
    port = f"mbap://127.0.0.1:{server.getsockname()[1]}"
    with server:
        says = {"closes": "the gateway takes no further connection, or restarts",
                "is silent": "not a (single )?byte came(; the gateway may serve one client| -> it may serve one client)"}[does]
        found_alone(tool, f"a gateway that {does}", f"doctor {port} zlac8015d:1 --timeout 100", says)
        found_alone(tool, f"a gateway that {does}", f"read {port} zlac8015d:1 bus_voltage --timeout 100 --retries 0", says)
        found_alone(tool, f"a gateway that {does}", f"scan {port} --nodes 1-2 --timeout 50",
                    says if does == "closes" else "the gateway is connected, and may serve one client at a time")
        tool.check("no cable and no adapter is named", "cable" not in tool.last.out + tool.last.err, tool.found())


@scene()
def nothing(tool: Tool):
    """A line without a trouble has no finding."""
    with played(tool, [Trouble("")], 1) as (port, _):
        tool.run(f"doctor {port} zlac8015d:1")
        others = [line for line in findings(tool.last.out) if not re.search(LATE, line)]
        tool.is_equal("nothing is found where nothing is", others, [])
        tool.run(f"scan {port} --nodes 1-3")
        tool.out_is("scan: and the drive has its name", "- - 1 zlac8015d")


play_tool()
