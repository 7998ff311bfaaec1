# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A line with a tap for `servobus listen`, which counts every byte that the listener sends.

The test writes frames into the tap, or relays what a client and a drive say to each other.
"""
import os
import select
import threading
import time
import tty
from pathlib import Path


def open_terminal(link: Path) -> tuple[int, int]:
    """Makes the link to a new pseudo-terminal; returns its two sides."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    link.unlink(missing_ok=True)
    link.symlink_to(os.ttyname(theirs))
    return ours, theirs


class TappedLine:
    """The listener's side stays open here: what a listener leaves behind as it ends is counted too."""

    def __init__(self, ours: int, theirs: int | None = None):
        self.ours, self.theirs = ours, theirs
        self.sent = 0  # bytes of the listener
        self.carried = 0  # bytes between the client and the drive
        self.is_open = True
        self.between: dict[int, int] = {}  # where to pass on what comes from the client and from the drive
        self.wakes, self.wake = os.pipe()
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    @classmethod
    def at(cls, link: Path):
        return cls(*open_terminal(link))

    @classmethod
    def relay(cls, link: Path, client: Path, drive: Path):
        """`client` becomes a pseudo-terminal for a client. Both directions go to the tap too."""
        tap = cls.at(link)
        client_side, tap.client_keeper = open_terminal(client)
        drive_side = os.open(drive, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(drive_side)
        tap.between = {client_side: drive_side, drive_side: client_side}
        os.write(tap.wake, b"\n")
        return tap

    def read(self):
        while self.is_open:
            ready, _, _ = select.select([self.ours, self.wakes, *self.between], [], [])
            for one in ready:
                data = os.read(one, 4096)
                if one in self.between:
                    self.carried += len(data)
                    self.write(data)
                    os.write(self.between[one], data)
                elif one == self.ours:
                    self.sent += len(data)
                    if not data:  # the listener has closed its connection
                        return

    def write(self, data: bytes):
        while data:
            data = data[os.write(self.ours, data) :]

    def play(self, *frames: str | float):
        """Bytes in hex, which are written immediately, and seconds to wait."""
        for one in frames:
            if isinstance(one, str):
                self.write(bytes.fromhex(one))
            else:
                time.sleep(one)

    def hang_up(self):
        """The listener's port is gone."""
        self.stop_interpretation()
        for one in (self.theirs, self.ours):
            if one is not None:
                os.close(one)
        self.theirs = self.ours = None

    def stop_interpretation(self):
        if self.is_open:
            self.is_open = False
            os.write(self.wake, b"\n")
            self.reader.join()

    def close(self) -> int:
        """Returns how many bytes the listeners have sent."""
        time.sleep(0.1)  # for what the system has not passed on yet
        self.stop_interpretation()
        if self.ours is not None:
            self.hang_up()
        for one in self.between:
            os.close(one)
        if self.between:
            os.close(self.client_keeper)
        self.between = {}
        return self.sent
