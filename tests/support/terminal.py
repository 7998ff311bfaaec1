# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A program on a pseudo-terminal of its own, and what it shows there."""
import fcntl
import os
import select
import struct
import subprocess
import termios
import time
from pathlib import Path

from scenes import PATIENCE


class Terminal:
    """`status` is that of the program, once it has ended."""

    def __init__(self, command: list[str], folder: Path, env: dict[str, str] | None = None):
        self.ours, self.theirs = os.openpty()
        fcntl.ioctl(self.theirs, termios.TIOCSWINSZ, struct.pack("4H", 24, 200, 0, 0))  # lines are not scrolled
        self.shown = ""
        self.status: int | None = None
        # The first terminal that the leader of a session opens controls it.
        self.process = subprocess.Popen(["sh", "-c", 'exec "$@" <"$0" >"$0" 2>&1', os.ttyname(self.theirs), *command],
                                        cwd=folder, env={**os.environ, **(env or {})}, start_new_session=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.wait()
        os.close(self.ours)

    def shows(self, text: str) -> bool:
        """Waits until the text is shown; false if the program ends without it."""
        end = time.monotonic() + PATIENCE
        while text not in self.shown and self.process.poll() is None and time.monotonic() < end:
            self.read(0.02)
        return text in self.shown

    def type(self, keys: str):
        os.write(self.ours, keys.encode())

    def wait(self):
        """Waits for the end of the program, and takes what it has shown last."""
        end = time.monotonic() + PATIENCE
        while self.process.poll() is None and time.monotonic() < end:
            self.read(0.02)
        self.process.kill()
        self.status = self.process.wait()
        if self.theirs is not None:
            os.close(self.theirs)  # so that interpretation ends
            self.theirs = None
            while self.read(1):
                pass

    def read(self, seconds: float) -> bool:
        if not select.select([self.ours], [], [], seconds)[0]:
            return False
        try:
            data = os.read(self.ours, 4096)
        except OSError:  # the other side is closed
            return False
        self.shown += data.decode(errors="replace")
        return bool(data)
