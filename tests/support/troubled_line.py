# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A line between a program and simulated drives on which troubles are planted, and counted as they happen."""
import heapq
import os
import pty
import random
import select
import threading
import time
import tty
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from any_device import crc

GAP = 0.004  # s, after which a frame is over


@dataclass
class Troubles:
    """What is planted. Times in seconds, probabilities of a response; 0 is none."""

    delay: float = 0.0  # of each response
    second_after: float = 0.0  # the second drive's response, after the first one's
    is_echoing: bool = False  # the program receives what it sends
    byte_each: float = 0.0  # a byte that nobody asked for
    master_each: float = 0.0  # a request of another master to node 7, and its response
    answers_every: int = 1  # of so many requests
    lost: float = 0.0
    damaged: float = 0.0
    happened: dict[str, int] = field(default_factory=dict)

    def note(self, what: str):
        self.happened[what] = self.happened.get(what, 0) + 1


def frame(text: str) -> bytes:
    body = bytes.fromhex(text)
    return body + crc(body)


class TroubledLine:
    def __init__(self, drives: list[Path], troubles: Troubles, seed: int):
        self.troubles = troubles
        self.dice = random.Random(seed)
        self.ours, self.theirs = pty.openpty()
        tty.setraw(self.theirs)
        self.name = os.ttyname(self.theirs)
        self.drives = [os.open(drive, os.O_RDWR | os.O_NOCTTY) for drive in drives]
        for drive in self.drives:
            tty.setraw(drive)
        self.planned: list[tuple[float, int, bytes]] = []  # when what is written to the program
        self.requests = 0
        self.is_over = False
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    def close(self):
        self.is_over = True
        self.thread.join()
        for port in (self.ours, self.theirs, *self.drives):
            os.close(port)

    def prepare(self, after: float, data: bytes):
        heapq.heappush(self.planned, (time.monotonic() + after, len(self.planned), data))

    def carry(self):
        next_byte = next_master = time.monotonic()
        while not self.is_over:
            now = time.monotonic()
            while self.planned and self.planned[0][0] <= now:
                os.write(self.ours, heapq.heappop(self.planned)[2])
            if self.troubles.byte_each and now >= next_byte:
                next_byte = now + self.troubles.byte_each
                self.troubles.note("byte_each")
                os.write(self.ours, b"\x55")
            if self.troubles.master_each and now >= next_master:
                next_master = now + self.troubles.master_each
                self.troubles.note("master_each")
                os.write(self.ours, frame("07 03 00 10 00 01"))
                self.prepare(0.012, frame("07 03 02 00 2A"))
            ready = select.select([self.ours, *self.drives], [], [], 0.002)[0]
            for one in ready:
                data = self.whole(one)
                if one == self.ours:
                    self.ask(data)
                elif data:
                    self.answer(self.drives.index(one), data)

    @staticmethod
    def whole(port: int) -> bytes:
        data = b""
        while select.select([port], [], [], GAP)[0]:
            try:
                data += os.read(port, 512)
            except OSError:  # nobody has it open
                time.sleep(0.01)
                break
        return data

    def ask(self, request: bytes):
        if not request:
            return
        self.requests += 1
        if self.troubles.is_echoing:
            self.troubles.note("is_echoing")
            os.write(self.ours, request)
        if self.requests % self.troubles.answers_every:
            return self.troubles.note("answers_every")
        for drive in self.drives:
            os.write(drive, request)

    def answer(self, number: int, response: bytes):
        t = self.troubles
        if self.dice.random() < t.lost:
            return t.note("lost")
        if self.dice.random() < t.damaged:
            t.note("damaged")
            at = self.dice.randrange(len(response))
            response = response[:at] + bytes([response[at] ^ 1 << self.dice.randrange(8)]) + response[at + 1 :]
        if t.delay:
            t.note("delay")
        if number:
            t.note("second_after")
        self.prepare(t.delay + number * t.second_after, response)


@contextmanager
def troubled_line(drives: list[Path], troubles: Troubles, seed: int = 1):
    """Gives the path of the program's end."""
    line = TroubledLine(drives, troubles, seed)
    try:
        yield line.name
    finally:
        line.close()
