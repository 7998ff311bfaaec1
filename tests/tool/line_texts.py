# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the tool says of a line, each text with the bytes that lead to it."""
import os
import re
import select
import sys
import threading
import time
import tty
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import crc
from programs import Tool, play_tool, scene


def frame(text: str) -> bytes:
    body = bytes.fromhex(text)
    return body + crc(body)


GOOD = frame("01 03 02 00 07")
OTHER = frame("01 03 02 00 08")
BAD_CRC = GOOD[:-1] + bytes([GOOD[-1] ^ 1])
NODE_2 = frame("02 03 02 00 07")
REFUSED = frame("01 83 02")
ECHO = b"echo"  # stands for the request itself

# By name: what comes after each request, with its seconds; `every`: the same after each of so many requests, and nothing
# after the others; `unasked`: what comes by itself each 30 ms.
LINES: dict[str, dict] = {
    "nothing comes": dict(),
    "a response": dict(after=[(0, GOOD)]),
    "an exception": dict(after=[(0, REFUSED)]),
    "a response after 200 ms": dict(after=[(0.2, GOOD)]),
    "a response after 400 ms": dict(after=[(0.4, GOOD)]),
    "two responses": dict(after=[(0, GOOD), (0.008, GOOD)]),
    "two responses that differ": dict(after=[(0, GOOD), (0.008, OTHER)]),
    "a response, and two bytes": dict(after=[(0, GOOD), (0.008, b"\x55\x66")]),
    "a response to every third request": dict(after=[(0, GOOD)], every=3),
    "a wrong CRC": dict(after=[(0, BAD_CRC)]),
    "a begin": dict(after=[(0, GOOD[:4])]),
    "a response of node 2": dict(after=[(0, NODE_2)]),
    "two bytes": dict(after=[(0, b"\x55\x55")]),
    "the request": dict(after=[(0, ECHO)]),
    "the request, and a response": dict(after=[(0, ECHO), (0.004, GOOD)]),
    "a byte each 30 ms": dict(after=[(0, GOOD)], unasked=b"\x55"),
    "frames of node 7 each 30 ms": dict(after=[(0, GOOD)], unasked=frame("07 03 02 00 2A")),
}


@contextmanager
def played(after=(), every: int = 1, unasked: bytes = b""):
    """Gives the path of a pseudo-terminal on which this comes."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    is_over = threading.Event()

    def serve():
        asked, planned, next_byte = 0, [], time.monotonic()
        while not is_over.is_set():
            now = time.monotonic()
            if unasked and now >= next_byte:
                next_byte = now + 0.03
                os.write(ours, unasked)
            for one in [one for one in planned if one[0] <= now]:
                planned.remove(one)
                os.write(ours, one[1])
            if not select.select([ours], [], [], 0.002)[0]:
                continue
            request = os.read(ours, 512)
            asked += 1
            if asked % every == 0 and request[0] == 1:
                planned += [(time.monotonic() + at, request if data == ECHO else data) for at, data in after]

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        is_over.set()
        thread.join()
        os.close(ours)
        os.close(theirs)


def plain(text: str, port: str) -> list[str]:
    """Without times, counts of what comes by itself, and names of ports, which differ from run to run."""
    text = text.replace(port, "PORT")
    text = re.sub(r"\b[0-9]+\.[0-9] ms", "T ms", text)
    text = re.sub(r"(csv:1 --retries 0|give) --timeout [0-9]+", r"\1 --timeout N", text)
    text = re.sub(r"\b[0-9]+ (bytes?|frames?) came in 30[0-9] ms", r"N \1 came in 300 ms", text)
    text = re.sub(r"\b[0-9]+ (bytes?|frames?) came in 10[0-9] ms", r"N \1 came in 100 ms", text)
    usual = "line |.* a response began after|servobus: .* [0-9]+ of [0-9]+$|.* is a pseudo-terminal"
    return [line for line in text.splitlines() if not re.match(usual, line)]


ANOTHER_SENDS = "another program or master sends on this line, or it picks up noise"
UNASKED = "another program or device sends on this line, or it picks up noise"
ONE_MASTER = "a line has one master: end the other; then termination, common ground and bias resistors"
TWO = "a request to node 1 had two responses{}: two devices have this address, or something on the line sends them twice; a " \
      "value may be of another register"
LONGER = "servobus doctor PORT meter.csv:1 --retries 0 --timeout N, and with every command; in a program a longer " \
         "limits.response of the node"
DAMAGE = "another rate or format, two devices at one address, another program, or noise"
ECHO_ON = "what came is the request's own echo: try --echo on"
NO_USE = "meter.csv:1: 1 finding keeps it from being used"
MATTERS = "meter.csv:1: 1 finding matters"
UNKNOWN = "- - 1 unknown device"


def damaged(what: str, more: str = "") -> dict[str, list[str]]:
    """`what`: of 6 reads by scan, of 30 by doctor; {0} stands for their number."""
    came = "{1} bytes came, none a response of node 1: of {0} reads {0} " + what + more
    size = {"with a wrong CRC": 7, "cut short": 4}.get(what, 7 if more else 2)
    return {"doctor": ["refused  " + came.format(30, 30 * size) + f", at 9600 8N1 -> {DAMAGE}: try servobus scan PORT, then "
                       "termination and common ground", NO_USE],
            "scan": ["- - 1 garbled", "servobus: - -: " + came.format(6, 6 * size) + f": {DAMAGE}"]}


SAID: dict[str, dict[str, list[str]]] = {
    "nothing comes": {
        "doctor": ["refused  no response, node 1 at 9600 8N1: not a single byte came -> the supply, A and B swapped, the node, "
                   "the rate, the format, or the adapter's direction: try swapping A and B, then servobus scan PORT, and with "
                   "--timeout 500", NO_USE],
        "scan": ["servobus: no device responds within 150 ms: a slower one needs --timeout 500; else the supply, A and B "
                 "swapped, or another rate, format or address"],
        "read": ["servobus: first: no response"]},
    "a response": {"doctor": ["meter.csv:1: nothing found"], "scan": [UNKNOWN], "read": ["first=7"]},
    "an exception": {
        "doctor": ["unread   first: refused, exception 2 (illegal data address)", MATTERS],
        "scan": [UNKNOWN],
        "read": ["servobus: first: refused, exception 2 (illegal data address)"]},
    "a response after 200 ms": {
        "doctor": ["matters  responses begin after up to T ms of the 300 ms that are allowed: some will be late -> "
                   + LONGER, MATTERS],
        "scan": [UNKNOWN, "servobus: - -: node 1 responds after T ms, later than the 150 ms that are allowed: give --timeout "
                 "N with every command"],
        "read": ["first=7"]},
    "a response after 400 ms": {
        "doctor": ["refused  30 of 30 responses began after the 300 ms that are allowed, the last after T ms -> "
                   + LONGER, NO_USE],
        "scan": [UNKNOWN, "servobus: - -: node 1 responds after T ms, later than the 150 ms that are allowed: give --timeout "
                 "N with every command"],
        "read": ["servobus: warning: responses of node 1 came after 300 ms: give --timeout more, or two devices have this "
                 "address", "servobus: first: no response"]},
    "two responses": {
        "doctor": ["refused  " + TWO.format("") + " -> take one of them off the line, and give it another address", NO_USE],
        "scan": ["- - 1 not identified", "servobus: - -: " + TWO.format("")],
        "read": ["first=7", "servobus: warning: " + TWO.format("")]},
    "two responses that differ": {
        "doctor": ["refused  " + TWO.format(" that differ") + " -> take one of them off the line, and give it another address",
                   NO_USE],
        "scan": ["- - 1 not identified", "servobus: - -: " + TWO.format("")],
        "read": ["first=7", "servobus: warning: " + TWO.format("")]},
    "a response, and two bytes": {
        "doctor": [f"matters  62 bytes came beside the responses: {ANOTHER_SENDS} -> end the other one; then termination, "
                   "common ground and bias resistors", MATTERS],
        "scan": [UNKNOWN, f"servobus: - -: 2 bytes came after the response of node 1: {ANOTHER_SENDS}"],
        "read": ["first=7", f"servobus: warning: 2 bytes came beside the responses: {ANOTHER_SENDS}"]},
    "a response to every third request": {
        "doctor": ["refused  20 of 30 reads have no response, 20 without a byte: writes will end as unknown, and setpoints be "
                   "late; the others begin within T ms -> check wires, termination, common ground and supply; a longer "
                   "--timeout is no help", NO_USE],
        "scan": [UNKNOWN, "servobus: - -: node 1 gave no response to the first request: a bad line, or a device that responds "
                 "now and then; doctor counts it", "servobus: - -: 6 of 9 reads of node 1 had no valid response: check wires, "
                 "termination, common ground and supply; doctor counts them"],
        "read": ["servobus: first: no response"]},
    "a wrong CRC": {**damaged("with a wrong CRC"), "read": ["servobus: first: wrong CRC"]},
    "a begin": {**damaged("cut short"), "read": ["servobus: first: the response stopped half-way"]},
    "a response of node 2": {**damaged("with other bytes", ", but frames of node 2"),
                             "read": ["servobus: first: 7 bytes came, none a response of node 1"]},
    "two bytes": {**damaged("with other bytes"),
                  "read": ["servobus: first: 2 bytes came, none a response of node 1"]},
    "the request": {
        "doctor": ["refused  what came is the request's own echo, and no response after it -> servobus doctor PORT "
                   "meter.csv:1 --echo on --timeout 300 --retries 0; if no response comes then, the supply, A and B swapped, or the node",
                   NO_USE],
        "scan": ["servobus: " + ECHO_ON],
        "read": ["servobus: first: " + ECHO_ON]},
    "the request, and a response": {
        "doctor": ["refused  the request's own echo comes before each response -> servobus doctor PORT meter.csv:1 --echo on "
                   "--timeout 300 --retries 0", NO_USE],
        "scan": ["servobus: " + ECHO_ON],
        "read": ["servobus: first: " + ECHO_ON]},
    "a byte each 30 ms": {
        "doctor": [f"refused  N bytes came in 300 ms while nothing was asked here: {UNASKED} -> {ONE_MASTER}", NO_USE],
        "scan": ["- - 1 not identified", f"servobus: - -: N bytes came in 100 ms while nothing was asked here: {UNASKED}"],
        "read": ["servobus: first: the line was not quiet long enough to send: another program or device sends on it, or it "
                 "picks up noise"]},
    "frames of node 7 each 30 ms": {
        "doctor": ["refused  N frames came in 300 ms while nothing was asked here, the first of node 7: another master or "
                   f"program is on this line -> {ONE_MASTER}", NO_USE],
        "scan": ["- - 1 not identified", "servobus: - -: N frames came in 100 ms while nothing was asked here, the first of node 7: another "
                 "master or program is on this line"],
        "read": ["servobus: first: the line was not quiet long enough to send: another program or device sends on it, or it "
                 "picks up noise"]},
}


@scene(*[(name, command) for name in LINES for command in ("doctor", "scan", "read")])
def said(tool: Tool, name: str, command: str):
    tool.write("meter.csv", "address,name,type,access\n1,first,u16,ro\n")
    words = {"doctor": "meter.csv:1 --timeout 300 --retries 0", "scan": "--nodes 1 --timeout 150",
             "read": "meter.csv:1 first --timeout 300 --retries 0"}[command]
    with played(**LINES[name]) as port:
        for again in range(10):
            tool.run(f"{command} {port} {words}")
            found = plain(tool.last.out + tool.last.err, port)
            if "unasked" in LINES[name] and found[0] == UNKNOWN:
                found[0] = "- - 1 not identified"  # as the bytes fall
            # A busy computer adds that responses are late.
            if found == SAID[name][command] or not any(re.search("began? after|begin after", line) for line in found):
                break
        if again:
            tool.say(f"        {name}: {command}: repeated {again} times, as this computer was late")
        tool.is_equal(f"{name}: {command}", found, SAID[name][command])


play_tool()
