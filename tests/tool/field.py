# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The requests of tests/field to `servobus sim`, over a pseudo-terminal: what a real drive took the simulated one takes.

support/field_sequence.hpp has the form of the files; run/sim/field.cpp plays them in virtual time.
"""
import os
import select
import signal
import sys
import termios
import time
import tty
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE / "support"))
from any_device import crc
from programs import Tool, play_tool, scene
from scenes import PATIENCE

SEQUENCES = sorted(path.stem for path in (HERE / "field").glob("*.txt"))


class Port:
    """A serial port that sends a request and takes the whole response."""

    def __init__(self, path: Path):
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)
        termios.tcflush(self.fd, termios.TCIOFLUSH)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.fd)

    def ask(self, request: bytes) -> bytes:
        """The response without its CRC; empty if none of a right CRC comes."""
        os.write(self.fd, request + crc(request))
        got, end = b"", time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if select.select([self.fd], [], [], 0.2 if got else PATIENCE)[0]:
                got += os.read(self.fd, 256)
            if len(got) >= 5 and crc(got[:-2]) == got[-2:]:
                return got[:-2]
        return b""


def is_wanted(wanted: str, request: bytes, got: bytes) -> bool:
    if len(got) < 3 or got[0] != request[0]:
        return False
    is_exception = bool(got[1] & 0x80)
    if wanted in ("ex", "any", "moves"):
        return is_exception == (wanted == "ex") and (wanted != "moves" or any(got[3:]))
    return got == {"echo": request, "ack10": request[:6]}.get(wanted) or \
        wanted not in ("echo", "ack10") and got == bytes.fromhex(wanted)


def lines_of(name: str):
    """Pairs of a word and the rest of its line."""
    for text in (HERE / "field" / f"{name}.txt").read_text("utf-8").splitlines():
        word, _, rest = text.split("#")[0].strip().partition(" ")
        if word:
            yield word, rest.strip()


def play_sequence(tool: Tool, name: str, device: str, how: list[str]) -> tuple[int, list[str]]:
    """How many requests were sent, and those that got another response."""
    sent, wrong = 0, []
    with tool.simulated(" ".join([device, *how])) as drive, Port(tool.folder / "drive") as port:
        for word, rest in lines_of(name):
            if word == "wait":
                time.sleep(int(rest) / 1000)
            elif word == "restart":
                drive.process.send_signal(signal.SIGUSR2)
                time.sleep(0.3)
            elif word == ">":
                hexes, wanted = (part.strip() for part in rest.split("="))
                request = bytes.fromhex(hexes)
                got = port.ask(request)
                sent += 1
                if not is_wanted(wanted, request, got):
                    wrong.append(f"> {rest}: {got.hex(' ')}")
    return sent, wrong


@scene(*SEQUENCES)
def sequence(tool: Tool, name: str):
    device = "zlac8015d" if name.startswith("zlac") else "c630s"
    switches = [rest for word, rest in lines_of(name) if word == "switch"]
    how = []
    if switches:
        tool.write("switches", "\n".join([f"servobus-findings format=1 device={device}", *switches]) + "\n")
        how = ["--switches", "switches"]
    sent, wrong = play_sequence(tool, name, device, how)
    tool.check(f"{name}: {sent} requests", sent > 8 and not wrong, "\n".join(wrong))


play_tool()
