#!/usr/bin/env python3
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A line with a tap for `servobus listen`, for listen.sh.

    tapped_line.py TAP TOLD play            each line of standard input is done, see below
    tapped_line.py TAP TOLD relay CLIENT DRIVE

TAP becomes a link to the pseudo-terminal of the listener; "tcp": a gateway for one connection instead, and TOLD gets
"port N" until it is there. TOLD gets a line "sent N" with the number of bytes that the listener has sent, again
whenever N changes, and first when all is ready.
play: a line is bytes in hex, which are written at once; "wait MS"; or "hang up", after which the tap is gone.
relay: CLIENT becomes a link to a pseudo-terminal for a client. What comes from it goes to DRIVE and to the tap, what
comes from DRIVE goes to the client and to the tap. It ends with standard input.
"""
import errno
import os
import select
import socket
import sys
import time
import tty


def link_to_new_terminal(path):
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    name = os.ttyname(theirs)
    if os.path.islink(path):
        os.unlink(path)
    os.symlink(name, path)
    return ours, theirs


class Tap:
    def __init__(self, path, told):
        self.told = told
        self.sent = 0
        if path == "tcp":
            with socket.create_server(("127.0.0.1", 0)) as server:
                self.write_told(f"port {server.getsockname()[1]}")
                self.ours = server.accept()[0].detach()
            self.theirs = None
        else:
            # The other side stays open here: what a listener leaves behind as it ends is read too.
            self.ours, self.theirs = link_to_new_terminal(path)
        self.tell()

    def write_told(self, line):
        with open(self.told + ".new", "w") as file:
            file.write(line + "\n")
        os.rename(self.told + ".new", self.told)

    def tell(self):
        self.write_told(f"sent {self.sent}")

    def write(self, data):
        self.look(0)
        while data:
            data = data[os.write(self.ours, data):]

    def look(self, seconds, *others):
        """Counts what comes out of the tap; returns those of the others that can be read."""
        end = time.monotonic() + seconds
        while True:
            ready, _, _ = select.select([self.ours, *others], [], [], max(0, end - time.monotonic()))
            if self.ours in ready:
                data = os.read(self.ours, 4096)
                if not data:
                    sys.exit("the listener has closed the connection")
                self.sent += len(data)
                self.tell()
                continue
            if ready or time.monotonic() >= end:
                return ready

    def hang_up(self):
        self.look(0)
        if self.theirs is not None:
            os.close(self.theirs)
        os.close(self.ours)


def play(tap):
    for line in sys.stdin:
        words = line.split()
        if words[:1] == ["wait"]:
            tap.look(int(words[1]) / 1000)
        elif words == ["hang", "up"]:
            return tap.hang_up()
        else:
            tap.write(bytes.fromhex(line))
    tap.look(0.1)


def relay(tap, client_path, drive_path):
    client, client_side = link_to_new_terminal(client_path)
    drive = os.open(drive_path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(drive)
    while True:
        for one in tap.look(1, client, drive, sys.stdin.fileno()):
            if one == sys.stdin.fileno():
                if not os.read(one, 4096):
                    return tap.look(0.1)
                continue
            data = os.read(one, 4096)
            tap.write(data)
            os.write(drive if one == client else client, data)


def main():
    tap = Tap(sys.argv[1], sys.argv[2])
    if sys.argv[3] == "play":
        play(tap)
    else:
        relay(tap, *sys.argv[4:])


try:
    main()
except OSError as error:
    if error.errno != errno.EIO:
        raise
