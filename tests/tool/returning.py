# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Ports that are lost and return: gateways that close their connections, or restart, and a serial port that is pulled."""
import re
import signal
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, on_terminal
from programs import Tool, play_tool, scene, until

WAIT = "--timeout 2000"


def numbered() -> Device:
    device = Device()
    device.holding = [1000 + i for i in range(256)]
    return device


def line_of(address: int) -> str:
    return f"0x{address:04X}={1000 + address} (0x{1000 + address:04X})"


@scene("tcp", "mbap")
def closed_after_each_response(tool: Tool, scheme: str):
    device = numbered()
    with Gateway(device, scheme, closes_after=1) as gateway:
        said = f"servobus: {gateway.name} closes its connections; each is made anew\n"
        tool.says(f"{scheme}: read goes on", f"read {gateway.name} raw 1 2 3 {WAIT}", *[line_of(i) for i in (1, 2, 3)])
        tool.is_equal(f"{scheme}: says so once", tool.last.err, said)
        tool.is_equal(f"{scheme}: each register is asked for once", len(device.requests), 3)
        device.requests.clear()
        tool.run(f"write {gateway.name} raw 1=5 2=6 coil:3=on 7:2=8,9 --yes {WAIT}")
        tool.check(f"{scheme}: write goes on", tool.last.status == 0 and len(tool.last.lines) == 5)
        tool.check(f"{scheme}: says so once too", tool.last.err.count(said) == 1)
        written = [pdu.hex() for pdu in device.requests if pdu[0] > 4]
        tool.is_equal(f"{scheme}: each write is sent once", written,
                      ["0600010005", "0600020006", "050003ff00", "10000700020400080009"])
        started = tool.start(f"watch {gateway.name} raw 1 4 --count 4 --interval 10 {WAIT}")
        tool.ends(started)
        tool.check(f"{scheme}: watch goes on", len(tool.last.lines) == 4 and "(" not in
                   "".join(re.sub(r"\(0x.{4}\)", "", line) for line in tool.last.lines))
        tool.status_is(f"{scheme}: with status 0", 0)
        tool.check(f"{scheme}: watch says so once", tool.last.err.count(said) == 1)
        tool.says(f"{scheme}: scan goes on", f"scan {gateway.name} --nodes 1-3 {WAIT}",
                  *[f"- - {node} unknown device" for node in (1, 2, 3)])


@scene("tcp", "mbap")
def gateway_that_restarts(tool: Tool, scheme: str):
    device = numbered()
    gateway = Gateway(device, scheme)
    watcher = tool.start(f"watch {gateway.name} raw 1 2 --csv --interval 20 {WAIT}")

    def comes(name: str, pattern: str):
        tool.check(f"{scheme}: {name}", until(lambda: re.search(pattern, watcher.out + watcher.err)),
                   watcher.out[-1000:] + watcher.err)

    comes("rows come", r",,\d*,1001,1002\n")
    gateway.stop()
    comes("a lost gateway is a row with an error", r"0x0001: the port is gone[^,]*,\d*,nan,nan\n$|nan,nan\n")
    comes("and is said", f"servobus: {gateway.name} is gone: .*; waiting for it\n")
    rows = len(watcher.out.splitlines())
    with Gateway(device, scheme, port=gateway.number):
        comes("it is back", f"servobus: {gateway.name} is back\n")
        tool.check(f"{scheme}: and its values", until(lambda: watcher.out.splitlines()[rows:] and
                                                      watcher.out.endswith("1001,1002\n")))
        tool.ends(watcher, signal.SIGINT)
    tool.status_is(f"{scheme}: Ctrl-C ends with status 0", 0)
    tool.is_equal(f"{scheme}: each is said once", tool.last.err.count(" is gone: "), 1)


@scene("tcp", "mbap")
def gateway_that_is_away_for_a_moment(tool: Tool, scheme: str):
    device = numbered()
    gateway = Gateway(device, scheme, closes_after=1, serves=1)
    again = []

    def restart():
        until(lambda: gateway.thread.is_alive() is False)
        time.sleep(0.4)
        again.append(Gateway(device, scheme, port=gateway.number))

    thread = threading.Thread(target=restart, daemon=True)
    thread.start()
    tool.says(f"{scheme}: read waits for it", f"read {gateway.name} raw 1 2 3 {WAIT}",
              *[line_of(i) for i in (1, 2, 3)])
    tool.err_has(f"{scheme}: and says so", f"servobus: {gateway.name} is gone: ")
    tool.err_has(f"{scheme}: and that it is back", f"servobus: {gateway.name} is back\n")
    thread.join()
    for one in again:
        one.stop()


@scene("tcp", "mbap")
def write_whose_connection_is_lost(tool: Tool, scheme: str):
    device = numbered()
    with Gateway(device, scheme, drops=2) as gateway:
        tool.run(f"write {gateway.name} raw 1=5 2=6 3=7 --yes {WAIT}")
        tool.status_is(f"G15: {scheme}: a write whose connection is lost ends it", 1)
        tool.err_has(f"{scheme}: its outcome is unknown", "2: unknown, the port is gone")
        tool.err_has(f"{scheme}: and what was written is said", "; 1 of 3 written")
        sent = [pdu.hex() for pdu in device.requests if pdu[0] == 6]
        tool.is_equal(f"G15: {scheme}: it is not sent again", sent, ["0600010005", "0600020006"])


@scene(0, 1, 3, 65535)
def damaged_header(tool: Tool, length: int):
    """One wrong header of Modbus TCP from a peer that has answered rightly before is damage, no other protocol."""
    with Gateway(numbered(), "mbap", damages=2, wrong_length=length) as gateway:
        tool.run(f"watch {gateway.name} raw 1 --count 4 --interval 20 --timeout 300")
        tool.status_is(f"length {length}: watch goes on", 0)
        values = tool.last.out.count(line_of(1))
        tool.check(f"length {length}: each round but one has its value", values >= 3, tool.found())
        tool.check(f"length {length}: no other protocol is named", "tcp://" not in tool.last.err, tool.last.err)
    device = numbered()
    with Gateway(device, "mbap", damages=2, wrong_length=length) as gateway:
        tool.run(f"write {gateway.name} raw 1=5 --yes {WAIT}")
        tool.is_equal(f"G15: length {length}: a write is not sent again",
                      [pdu.hex() for pdu in device.requests if pdu[0] == 6], ["0600010005"])
    if length == 3:
        return  # of a frame with that length the first header is right
    with Gateway(numbered(), "mbap", damages=1, wrong_length=length) as gateway:
        tool.run(f"read {gateway.name} raw 1 --timeout 300")
        tool.err_has(f"length {length}: of a peer that never was right the other protocol is named",
                     "what came is no Modbus TCP: try tcp://")


@scene()
def serial_port(tool: Tool):
    options = "--interval 20 --timeout 300 --retries 0"
    with tool.simulated("zlac8015d") as drive:
        watcher = tool.start(f"watch drive zlac8015d bus_voltage --csv {options}")
        tool.check("rows come", until(lambda: ",24.00\n" in watcher.out), watcher.err)
        drive.stop()
        is_said = until(lambda: "servobus: drive is gone: " in watcher.err)
        tool.check("a pulled port is said", is_said, watcher.err)
    rows = len(watcher.out.splitlines())
    tool.check("each round has a row meanwhile", until(lambda: len(watcher.out.splitlines()) > rows + 2))
    with tool.simulated("zlac8015d"):
        tool.check("it is back", until(lambda: "servobus: drive is back\n" in watcher.err), watcher.err)
        tool.check("and its values", until(lambda: watcher.out.endswith(",24.00\n")), watcher.out[-500:])
        tool.ends(watcher, signal.SIGINT)
    tool.status_is("Ctrl-C ends with status 0", 0)


@scene()
def serial_port_that_a_write_loses(tool: Tool):
    """The port is back at once, with another device: the write may have been carried out already."""
    first, second = numbered(), numbered()
    first.is_pulled_by_write = True
    with on_terminal(first) as pulled, on_terminal(second) as plugged:
        drive = tool.folder / "port"
        drive.symlink_to(pulled)

        def plug():
            until(lambda: any(pdu[0] == 6 for pdu in first.requests))
            (tool.folder / "other").symlink_to(plugged)
            (tool.folder / "other").rename(drive)

        thread = threading.Thread(target=plug, daemon=True)
        thread.start()
        tool.run(f"write port raw 1=5 2=6 --yes {WAIT}")
        thread.join()
        tool.status_is("G15: a write whose port is lost ends it", 1)
        tool.err_has("its outcome is unknown", "1: unknown, the port is gone")
        tool.is_equal("G15: it is not sent again", second.requests, [])


@scene()
def pulled_until_the_end(tool: Tool):
    with tool.simulated("zlac8015d") as drive:
        watcher = tool.start("watch drive zlac8015d bus_voltage --count 40 --interval 20 --timeout 300 --retries 0")
        tool.check("rounds come", until(lambda: "=24.00 V" in watcher.out), watcher.err)
        drive.stop()
        tool.ends(watcher)
    tool.status_is("a port that is gone at the end is status 1", 1)
    tool.is_equal("after all rounds", len(tool.last.lines), 40)
    tool.is_equal("and said at the end", tool.last.err_lines[-1].startswith("servobus: the port is gone"), True)


play_tool()
