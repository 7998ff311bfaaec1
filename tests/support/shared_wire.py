# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A line that several simulated drives share: a pseudo-terminal whose bytes all of them get, and which says what any says."""
import os
import pty
import select
import threading
import tty
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def shared_wire(drives: list[Path], programs: int = 1):
    """Gives the path of the line, or one for each of several programs. They may be opened again and again."""
    masters, slaves = zip(*[pty.openpty() for _ in range(programs)])
    for slave in slaves:
        tty.setraw(slave)
    ports = [os.open(drive, os.O_RDWR | os.O_NOCTTY) for drive in drives]
    stop = threading.Event()

    def carry():
        while not stop.is_set():
            for ready in select.select([*masters, *ports], [], [], 0.02)[0]:
                came = os.read(ready, 512)
                for other in ports if ready in masters else masters:
                    os.write(other, came)

    thread = threading.Thread(target=carry)
    thread.start()
    try:
        names = [os.ttyname(slave) for slave in slaves]
        yield names[0] if programs == 1 else names
    finally:
        stop.set()
        thread.join()
        for port in (*masters, *slaves, *ports):
            os.close(port)
