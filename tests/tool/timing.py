# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Options of the line: how long responses are awaited, what is quiet between them, and how a frame may pause."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from programs import Tool, play_tool, scene

NOWHERE = "/dev/no-such-port"


def numbered() -> Device:
    device = Device()
    device.holding = [1000 + i for i in range(256)]
    return device


@scene(
    # At the end of the drive's own quarantine of 100 ms the response was taken for that of the next request.
    ("a longer timeout has a longer quarantine", "--timeout 400", 0.6),
    ("a shorter timeout leaves the drive the time that it has", "--timeout 40", 0.17),
    ("a quarantine that is given", "--timeout 100 --quarantine 600", 0.5),
)
def late_response(tool: Tool, name: str, options: str, delay: float):
    device = numbered()
    device.delays = [delay]
    with on_terminal(device) as port:
        tool.run(f"read {port} raw 1 2 --retries 0 {options}")
        tool.out_is(f"G2: {name}: the next value is its own", "0x0002=1002 (0x03EA)")
        tool.is_equal("and the late one is none", tool.last.err, "servobus: 1: no response\n")
        device.delays = [delay]
        tool.run(f"read {port} raw 3 4 --retries 2 {options}")
        tool.out_is(f"G2: {name}: a retry too", "0x0003=1003 (0x03EB)", "0x0004=1004 (0x03EC)")


@scene()
def a_gap_and_a_quarantine(tool: Tool):
    device = numbered()
    with on_terminal(device) as port:

        def pause(words: str) -> float:
            """Seconds between the last two requests."""
            device.began.clear()
            tool.run(f"read {port} {words}")
            return device.began[-1] - device.began[-2]

        tool.check("--gap: the pause before each request", pause("raw 1 2 --timeout 2000 --gap 300") > 0.29)
        tool.check("--gap: and each value is read", len(tool.last.lines) == 2)
        usual = pause("raw 1 2 --timeout 2000")
        tool.check("without it there is none", usual < 0.29, usual)
        device.delays = [0.05]
        started = pause("raw 1 2 --timeout 10 --retries 0 --quarantine 700")
        tool.check("--quarantine: the pause after no response", started > 0.7, started)
        tool.out_is("--quarantine: in which the late response is dropped", "0x0002=1002 (0x03EA)")


@scene()
def pause_in_a_response(tool: Tool):
    device = numbered()
    device.pause = 0.15
    with on_terminal(device) as port:
        tool.run(f"read {port} raw 1 --timeout 2000 --retries 0")
        tool.is_equal("a response that pauses is cut", tool.last.err, "servobus: 1: the response stopped half-way\n")
        tool.says("--inter-byte: it is whole", f"read {port} raw 1 --timeout 2000 --retries 0 --inter-byte 800",
                  "0x0001=1001 (0x03E9)")


@scene()
def refused(tool: Tool):
    for option in ("gap", "quarantine", "inter-byte"):
        tool.fails(f"--{option} takes milliseconds", f"read {NOWHERE} raw 1 --{option} soon", 2,
                   f"--{option} takes a whole number from 0 to")
    tool.fails("listen --inter-byte too", f"listen {NOWHERE} raw --inter-byte -1", 2, "--inter-byte takes a whole number")


play_tool()
