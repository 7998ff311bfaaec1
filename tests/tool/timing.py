# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Options of the line: how long responses are awaited, what is quiet between them, and how a frame may pause."""
import sys
import time
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
        limit = options.split()[1]
        tool.is_equal("and the late one is none, and said to be late", tool.last.err,
                      f"servobus: warning: responses of node 1 came after {limit} ms: give --timeout more, or two devices "
                      "have this address\nservobus: 1: no response\n")
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
def scanned(tool: Tool):
    """The same options of a scan."""
    device = numbered()
    device.server_id = b"pump"
    with on_terminal(device) as port:

        def pauses(options: str) -> list[float]:
            """Seconds between the requests to the one device that there is."""
            device.began.clear()
            tool.run(f"scan {port} --nodes 1-2 --timeout 1000 {options}")
            return [later - earlier for earlier, later in zip(device.began, device.began[1:])]

        tool.check("scan: without an option there is no pause", min(pauses("")) < 0.19)
        tool.out_is("scan: and the device is found", "- - 1 unknown device")
        tool.check("scan --gap: the pause before each request", min(pauses("--gap 200 --identify")) > 0.19)
        tool.out_is("scan --gap: the device is found", '- - 1 unknown device: server ID "pump"')
        device.delays = [0.05]
        device.began.clear()
        tool.run(f"scan {port} --nodes 1-1 --timeout 10")
        tool.out_is("scan: a late device is found", "- - 1 unknown device")
        device.pause = 0.15
        tool.run(f"scan {port} --nodes 1 --timeout 1000")
        tool.out_is("scan: a response that pauses is garbled", "- - 1 garbled")
        tool.run(f"scan {port} --nodes 1 --timeout 1000 --inter-byte 800")
        tool.out_is("scan --inter-byte: it is whole", "- - 1 unknown device")


@scene(("", 0.0, 0.4), ("--quarantine 500", 0.45, 9.0))
def scan_after_no_response(tool: Tool, options: str, shortest: float, longest: float):
    """Node 1 does not respond, node 2 does."""
    device = numbered()
    with on_terminal(device, node=2) as port:
        began = time.monotonic()
        tool.run(f"scan {port} --nodes 1-9 --timeout 300 {options}")
        pause = device.began[0] - began - 0.3
        tool.check(f"scan {options}: the pause after no response", shortest <= pause <= longest, pause)
        tool.out_is("and node 2 is found", "- - 2 unknown device")


@scene()
def refused(tool: Tool):
    for option in ("gap", "quarantine", "inter-byte"):
        tool.fails(f"--{option} takes milliseconds", f"read {NOWHERE} raw 1 --{option} soon", 2,
                   f"--{option} takes a whole number from 0 to")
        tool.fails(f"scan --{option} too", f"scan {NOWHERE} --{option} soon", 2,
                   f"--{option} takes a whole number from 0 to")
    tool.fails("listen --inter-byte too", f"listen {NOWHERE} raw --inter-byte -1", 2, "--inter-byte takes a whole number")


play_tool()
