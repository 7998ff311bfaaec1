# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A gateway for RTU frames over TCP that is late once, and loses nothing, as a network does.

    stalling_gateway.py DRIVE AFTER SECONDS

DRIVE is the terminal of a simulated drive. Prints its port. One connection after the other, in the order in which they
were made. After so many requests the next ones wait for SECONDS, in their order. A request is carried out although its
connection was closed meanwhile, unless it was reset; each that is carried out is printed in hex, another one as
"dropped".
"""
import os
import select
import socket
import sys
import time
import tty


def response_of(drive):
    """What the drive says until it has been silent for 50 ms."""
    said = b""
    while select.select([drive], [], [], 0.05 if said else 0.3)[0]:
        said += os.read(drive, 512)
    return said


def is_reset(connection):
    return connection.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) != 0


def main():
    drive = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    tty.setraw(drive)
    after, seconds = int(sys.argv[2]), float(sys.argv[3])
    server = socket.create_server(("127.0.0.1", 0))
    print(server.getsockname()[1], flush=True)
    count = 0
    while True:
        connection, _ = server.accept()
        while True:
            try:
                request = connection.recv(512)
                if not request:
                    break
                count += 1
                if count == after + 1:
                    time.sleep(seconds)
                if is_reset(connection):
                    print("dropped", flush=True)
                    break
                print(request.hex(" "), flush=True)
                os.write(drive, request)
                connection.sendall(response_of(drive))
            except OSError:
                break
        connection.close()


main()
