#!/usr/bin/env python3
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A gateway from Modbus TCP to a serial port, written from the specification: mbap_gateway.py DEVICE prints its port.

It serves one connection and ends with it. A request without a response within 0.3 s gets exception 0Bh, as the
specification asks of a gateway.
"""
import os
import select
import socket
import sys
import termios
import tty


def crc(frame):
    value = 0xFFFF
    for byte in frame:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value.to_bytes(2, "little")


def exactly(connection, count):
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise ConnectionError
        data += more
    return data


def size_of(response):
    """With the CRC; 0 while it is not known."""
    if len(response) < 3:
        return 0
    if response[1] & 0x80:
        return 5
    return 8 if response[1] in (5, 6, 15, 16) else 5 + response[2]


def response_of(device, frame):
    termios.tcflush(device, termios.TCIFLUSH)
    os.write(device, frame + crc(frame))
    data = b""
    while select.select([device], [], [], 0.3)[0]:
        data += os.read(device, 300)
        size = size_of(data)
        if size and len(data) >= size:
            is_valid = crc(data[: size - 2]) == data[size - 2 : size]
            return data[: size - 2] if is_valid else bytes([frame[0], frame[1] | 0x80, 0x0B])
    return bytes([frame[0], frame[1] | 0x80, 0x0B])


def serve(connection, path):
    device = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(device)
    try:
        while True:
            header = exactly(connection, 6)
            frame = exactly(connection, int.from_bytes(header[4:6], "big"))
            answer = response_of(device, frame)
            # In pieces, as networks deliver.
            for byte in header[:4] + len(answer).to_bytes(2, "big") + answer:
                connection.sendall(bytes([byte]))
    except ConnectionError:
        pass
    finally:
        os.close(device)
        connection.close()


def main():
    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    listening.listen(1)
    print(listening.getsockname()[1], flush=True)
    connection = listening.accept()[0]
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    serve(connection, sys.argv[1])


main()
