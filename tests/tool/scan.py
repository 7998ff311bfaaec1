# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus scan, and adapters with a local echo."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, Gateway, on_terminal
from programs import Tool, play_tool, scene


@scene()
def refused(tool: Tool):
    for name, words, status, text in [
        ("scan: no port named", "scan", 2, "scan takes one PORT"),
        ("scan: no such port", "scan /dev/no-such-port", 1, "cannot open"),
        ("scan: addresses that no device has", "scan drive --nodes 0-5", 2, "--nodes takes addresses from 1 to 247"),
        ("scan: a rate that does not exist", "scan drive --baud 9600,12", 2, "--baud takes rates"),
    ]:
        tool.fails(name, words, status, text)


@scene(
    ("zlac8015d", "115200 8N1", 5, "zlac8015d"),
    ("yako-closed-loop", "115200 8N1", 3, "yako-closed-loop"),
    ("yako-open-loop", "115200 8N1", 1, "yako-open-loop"),
    ("c630s", "57600 8N2", 2, "c630s"),
)
def found_and_named(tool: Tool, device: str, setting: str, node: int, name: str):
    rate, form = setting.split()
    with tool.simulated(f"{device} --node {node}"):
        tool.exits(f"scan: {device} is found and named", f"scan drive --baud {rate} --format {form} --nodes 1-6", 0)
        tool.out_is(f"scan: {device} alone", f"{setting} {node} {name}")
        tool.err_has("scan: shows how far it is", "6 of 6")


@scene()
def scanned_once(tool: Tool):
    """A pseudo-terminal has no rate: at each one the same drive would be found again."""
    with tool.simulated("zlac8015d --node 2"):
        tool.run("scan drive --nodes 1-3")
        tool.out_is("scan: a simulator is scanned once", "- - 2 zlac8015d")
        tool.status_is("scan: and ends with status 0", 0)
        tool.err_has("scan: it says why", "is a pseudo-terminal, which has no rate and no format: scanning once")
        # A line that moves ends with a carriage return.
        finished = [line for line in tool.last.err_lines if line.endswith(" 3 of 3")]
        tool.check("scan: nothing is scanned at a second rate", len(finished) == 1)
        tool.run("scan drive --nodes 2 --baud 115200 --format 8N1")
        tool.out_is("scan: one rate is shown as it was given", "115200 8N1 2 zlac8015d")
        tool.err_lacks("scan: without a remark", "pseudo-terminal")
    with tool.simulated("zlac8015d --node 2 --baud 57600 --strict-rate on"):
        tool.run("scan drive --nodes 2 --baud 9600,57600,115200 --format 8N1")
        tool.out_is("scan: one that insists on its rate is found there", "57600 8N1 2 zlac8015d")


class Mirror(Device):
    """Holds in each register what a drive would have there for its own address, or another word."""

    def __init__(self, words: dict[int, int], otherwise: int | None = None):
        super().__init__()
        self.words, self.otherwise = words, otherwise

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        word = self.words.get(int.from_bytes(pdu[1:3], "big"), self.otherwise)
        return bytes([pdu[0] | 0x80, 2]) if pdu[0] != 3 or word is None else bytes([3, 2]) + word.to_bytes(2, "big")


# The own address, and what else a scan looks at.
WHEELS = {0x2001: 1, 0x2011: 5, 0x2045: 15, 0x2002: 2}


@scene()
def late_response(tool: Tool):
    """The response to the first question about a drive comes after its time: it is not taken for that to the second."""
    device = Mirror(WHEELS)
    device.delays = [0, 0.12]
    with on_terminal(device) as port:
        for name in ["late once", "never late"]:
            tool.run(f"scan {port} --nodes 1-1 --timeout 60 --baud 115200 --format 8N1")
            tool.out_is(f"scan: a drive that is {name} has its own name", "115200 8N1 1 zlac8015d")


@scene(
    ("all registers hold 1", Mirror({}, 1)), ("all hold 5", Mirror({}, 5)), ("all hold 0", Mirror({}, 0)),
    ("a meter with its address at 0002h", Mirror({0x0001: 23000, 0x0002: 1})),
    ("one with its address at 2001h", Mirror({0x2001: 1})),
    ("pole pairs that no wheel has", Mirror({**WHEELS, 0x2045: 2})),
    ("one with its address at 0C00h", Mirror({0x0C00: 1})),
)
def no_proof(tool: Tool, name: str, device: Mirror):
    """A drive is named by registers that only it has, with values in their ranges."""
    with on_terminal(device) as port:
        tool.run(f"scan {port} --nodes 1 --timeout 500")
        tool.out_is(f"scan: {name}: no drive", "- - 1 unknown device")


@scene()
def not_identified(tool: Tool):
    """It responds, and not to what would name it."""
    device = Mirror(WHEELS)
    device.delays = [0] + [0.5] * 30
    with on_terminal(device) as port:
        tool.run(f"scan {port} --nodes 1 --timeout 30")
        tool.out_is("scan: a device whose responses are lost is not unknown", "- - 1 not identified")
        tool.err_has("and how many", "reads of node 1 had no valid response")


def objects(*texts: tuple[int, bytes]) -> bytes:
    return bytes([len(texts)]) + b"".join(bytes([number, len(text)]) + text for number, text in texts)


@scene("pty", "tcp", "mbap")
def identified(tool: Tool, scheme: str):
    """By function 2Bh in one part or in several, else by 11h, else not."""
    regular = Device()
    # After the kind: conformity, more follows, next object, and the objects.
    regular.identification[2] = [b"\x82\xff\x01" + objects((0, b"Acme")),
                                 b"\x82\x00\x00" + objects((1, b"P-\"1"), (2, b"V2\xff"), (0x80, b"x"))]
    basic = Device()
    basic.identification[1] = [b"\x01\x00\x00" + objects((0, b"Acme"), (1, b"P-1"), (2, b"V2"))]
    older = Device()
    older.server_id = b"pump\xff"
    for device, said in [
        (regular, r'vendor "Acme", product code "P-\x221", revision "V2\xFF", object 80 "x"'),
        (basic, 'vendor "Acme", product code "P-1", revision "V2"'),
        (older, r'server ID "pump\xFF"'),
        (Device(), "no identification"),
    ]:
        with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
            name = port if scheme == "pty" else port.name
            tool.run(f"scan {name} --nodes 1 --identify --timeout 2000")
            tool.out_is(f"{scheme}: scan --identify: {said}", f"- - 1 unknown device: {said}")
    tool.check(f"{scheme}: who is not asked says nothing", all(pdu[0] == 3 for pdu in asked_without(tool, scheme)))


def asked_without(tool: Tool, scheme: str) -> list[bytes]:
    device = Device()
    with on_terminal(device) if scheme == "pty" else Gateway(device, scheme) as port:
        tool.run(f"scan {port if scheme == 'pty' else port.name} --nodes 1 --timeout 2000")
    return device.requests


@scene()
def no_response(tool: Tool):
    with tool.simulated("zlac8015d --node 5"):
        tool.exits("G27: no response is reported", "scan drive --baud 115200 --format 8N1 --nodes 1-4", 1)
        tool.err_has("and said", "no device responds")


class Unanswered(Device):
    """A gateway behind which nobody responds."""

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        return bytes([pdu[0] | 0x80, 0x0B])


@scene()
def behind_a_gateway(tool: Tool):
    device = Unanswered()
    with Gateway(device, "mbap") as gateway:
        tool.run(f"scan {gateway.name} --nodes 1-3")
        tool.status_is("a gateway that got no response: status 1", 1)
        tool.out_is("names nobody")
        tool.is_equal("and says who has said so", tool.last.err_lines[-1],
                      "servobus: no device responds: the gateway says that it got no response at any address")
        tool.is_equal("each address is asked once", len(device.requests), 3)


@scene()
def after_a_change_of_address(tool: Tool):
    """The scan finds the drive. No write goes to an address that is not certain."""
    with tool.simulated("zlac8015d"):
        tool.exits("G24: an address is changed", "write drive zlac8015d node_address=9", 0)
        tool.run("write drive zlac8015d save_parameters=save_all --yes")
        tool.run("scan drive --baud 115200 --format 8N1 --nodes 1-10")
        tool.check("G24: scan finds the drive, at its old or new address", len(tool.last.lines) == 1)


@scene()
def local_echo(tool: Tool):
    with tool.simulated("zlac8015d --echo on"):
        # No drive is at these addresses, so nothing but the echo arrives.
        tool.run("scan drive --baud 115200 --format 8N1 --nodes 2-3")
        tool.err_has("G3: an echo is no response", "try --echo on")
        tool.run("scan drive --baud 115200 --format 8N1 --nodes 1-3 --echo on")
        tool.check("G4: without its echo the drive is found", "115200 8N1 1 zlac8015d" in tool.last.lines)
        tool.says("G4: and read", "read drive zlac8015d bus_voltage --echo on", "bus_voltage=24.00 V")
        tool.says("G4: and written", "write drive zlac8015d left_max_current=12.5 --echo on", "left_max_current=12.5 A")
        tool.exits("G3: an echo acknowledges nothing", "write drive zlac8015d left_max_current=13", 1)
        tool.err_has("G3: what came is an echo, as the read after it shows", "unknown, what came is the request's own echo")


@scene()
def echo_at_one_rate(tool: Tool):
    """An adapter whose echo comes at one of the rates alone: the others are scanned too."""
    asked = "scan drive --format 8N1 --nodes 2-3 --echo on"
    with tool.simulated("zlac8015d --node 2 --baud 57600 --strict-rate on --echo on"):
        tool.run(f"{asked} --baud 9600,57600,115200")
        tool.status_is("scan: a rate without an echo is not the end", 0)
        tool.out_is("scan: the drive is found at its rate", "57600 8N1 2 zlac8015d")
        tool.err_has("scan: the rate without an echo is named", "servobus: 9600 8N1: the request did not come back")
        tool.err_has("scan: and the one after it", "servobus: 115200 8N1: the request did not come back")
        tool.run("scan drive --format 8N1 --nodes 3 --echo on --baud 9600,57600")
        tool.status_is("scan: an echo and no device: status 1", 1)
        tool.err_has("scan: and it says so", "no device responds")
        tool.run(f"{asked} --baud 9600,115200")
        tool.status_is("scan: without an echo at any rate: status 1", 1)
        tool.err_has("scan: and it says so", "at any rate and format: try --echo off")
        tool.run(f"{asked} --baud 9600")
        tool.status_is("scan: without an echo at the only rate: status 1", 1)
        tool.err_has("scan: and it says where", "9600 8N1 node 2: ")


play_tool()
