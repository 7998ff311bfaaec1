# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A Modbus device with coils, inputs and registers, over a pseudo-terminal, RTU over TCP, or Modbus TCP.

It is written from the standard (Modbus Application Protocol V1.1b3), apart from the library.
"""
import os
import pty
import select
import socket
import struct
import threading
import time
import tty
from contextlib import contextmanager


def crc(data: bytes) -> bytes:
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value.to_bytes(2, "little")


def packed(bits: list[bool]) -> bytes:
    out = bytearray((len(bits) + 7) // 8)
    for i, is_on in enumerate(bits):
        out[i // 8] |= is_on << i % 8
    return bytes(out)


class Device:
    """Its tables, of 256 rows each; another address is exception 2, another function exception 1."""

    def __init__(self):
        self.coils = [False] * 256
        self.inputs = [i % 3 == 0 for i in range(256)]
        self.holding = [0] * 256
        self.input_registers = [0x1000 + i for i in range(256)]
        self.requests: list[bytes] = []  # the PDUs that came
        self.began: list[float] = []  # when each of them had come
        self.delays: list[float] = []  # s, before the next responses
        self.pause = 0.0  # s, inside each response on a terminal
        self.follows = 0.0  # s, after each response on a terminal: it is sent again, or `stray` is sent
        self.stray = b""
        self.is_pulled_by_write = False  # a terminal ends in place of the response
        self.identification: dict[int, list[bytes]] = {}  # by kind, the parts of function 2Bh after its kind
        self.server_id = b""
        self.own: dict[bytes, bytes] = {}  # functions of its own: the response to a PDU; empty: it says nothing

    def response_to(self, pdu: bytes) -> bytes:
        self.requests.append(pdu)
        self.began.append(time.monotonic())
        if pdu in self.own:
            return self.own[pdu]
        code = pdu[0]
        tables = {1: self.coils, 2: self.inputs, 3: self.holding, 4: self.input_registers}
        if code in tables:
            first, count = struct.unpack(">HH", pdu[1:5])
            rows = tables[code][first : first + count]
            if len(rows) < count:
                return bytes([code | 0x80, 2])
            data = packed(rows) if code < 3 else struct.pack(f">{count}H", *rows)
            return bytes([code, len(data)]) + data
        if code == 43 and pdu[2] in self.identification:
            parts = self.identification[pdu[2]]
            return pdu[:3] + next(part for part in parts if part[4] == pdu[3])
        if code == 17 and self.server_id:
            return bytes([17, len(self.server_id)]) + self.server_id
        if code not in (5, 6, 15, 16):
            return bytes([code | 0x80, 3 if code == 43 and self.identification else 1])
        first, value = struct.unpack(">HH", pdu[1:5])
        if code in (5, 6):
            values = [value] if code == 6 else [value == 0xFF00]
        elif code == 15:
            values = [bool(pdu[6 + i // 8] >> i % 8 & 1) for i in range(value)]
        else:
            values = list(struct.unpack(f">{value}H", pdu[6:]))
        table = self.coils if code in (5, 15) else self.holding
        if first + len(values) > len(table):
            return bytes([code | 0x80, 2])
        table[first : first + len(values)] = values
        return pdu[:5]

    def answer(self, pdu: bytes) -> bytes:
        delay = self.delays.pop(0) if self.delays else 0
        response = self.response_to(pdu)
        time.sleep(delay)
        return response


def size_of_request(begun: bytes) -> int:
    """Of an RTU frame; more than has come while it is not known."""
    if len(begun) < 2:
        return 8
    if begun[1] in (15, 16):
        return 9 + begun[6] if len(begun) > 6 else 9
    return {17: 4, 43: 7, 0x42: 4}.get(begun[1], 8)


@contextmanager
def on_terminal(device: Device, node: int = 1, echoes: bool = False):
    """Gives the path of its pseudo-terminal."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    stop = threading.Event()

    def serve():
        begun = b""
        while not stop.is_set():
            if not select.select([ours], [], [], 0.01)[0]:
                continue
            came = os.read(ours, 512)
            if echoes:
                os.write(ours, came)
            begun += came
            while len(begun) >= size_of_request(begun):
                size = size_of_request(begun)
                frame, begun = begun[:size], begun[size:]
                if crc(frame[:-2]) == frame[-2:] and frame[0] == node:
                    if device.is_pulled_by_write and frame[1] > 4:
                        device.answer(frame[1:-2])
                        return
                    answer = device.answer(frame[1:-2])
                    if not answer:  # it does not know the function
                        continue
                    response = bytes([node]) + answer
                    response += crc(response)
                    if device.pause:
                        os.write(ours, response[:3])
                        response = response[3:]
                        time.sleep(device.pause)
                    os.write(ours, response)
                    if device.follows:
                        time.sleep(device.follows)
                        os.write(ours, device.stray or response)

    def run():
        serve()
        os.close(ours)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        stop.set()
        thread.join()
        os.close(theirs)


class Gateway:
    """The device behind a port of TCP.

    It closes each connection after so many responses (0: never by itself), ends after it has served so many, and closes
    a connection in place of the response to write number `drops`. Response number `damages` has a header of Modbus TCP
    with the length `wrong_length`.
    """

    def __init__(self, device: Device, scheme: str, *, closes_after=0, serves=0, drops=0, port=0, damages=0, wrong_length=0):
        self.device, self.scheme = device, scheme
        self.damages, self.wrong_length = damages, wrong_length
        self.closes_after, self.serves, self.drops = closes_after, serves, drops
        self.connections = 0
        self.units: list[int] = []  # of the requests on Modbus TCP
        self.server = socket.create_server(("127.0.0.1", port))
        self.number = self.server.getsockname()[1]
        self.name = f"{scheme}://127.0.0.1:{self.number}"
        self.server.settimeout(0.05)
        self.stopped = threading.Event()
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self):
        self.stopped.set()
        self.thread.join()

    def serve(self):
        while not self.stopped.is_set():
            try:
                connection = self.server.accept()[0]
            except TimeoutError:
                continue
            self.connections += 1
            with connection:
                connection.settimeout(0.05)
                self.talk(connection)
            if self.connections == self.serves:
                break
        self.server.close()

    def receive(self, connection, size: int) -> bytes:
        data = b""
        while len(data) < size and not self.stopped.is_set():
            try:
                more = connection.recv(size - len(data))
            except TimeoutError:
                continue
            if not more:
                break
            data += more
        return data

    def answer(self, pdu: bytes) -> bytes:
        response = self.device.answer(pdu)
        if len([sent for sent in self.device.requests if sent[0] > 4]) == self.drops != 0:
            raise ConnectionError
        return response

    def talk(self, connection):
        responses = 0
        while not self.stopped.is_set():
            try:
                if self.scheme == "mbap":
                    head = self.receive(connection, 7)
                    pdu = self.receive(connection, int.from_bytes(head[4:6], "big") - 1)
                    if not pdu:
                        return
                    self.units.append(head[6])
                    answer = self.answer(pdu)
                    is_damaged = len(self.device.requests) == self.damages
                    length = self.wrong_length if is_damaged else len(answer) + 1
                    connection.sendall(head[:4] + length.to_bytes(2, "big") + head[6:7] + answer)
                else:
                    frame = self.receive(connection, 4)
                    while len(frame) < size_of_request(frame):
                        more = self.receive(connection, 1)
                        if not more:
                            return
                        frame += more
                    answer = frame[:1] + self.answer(frame[1:-2])
                    connection.sendall(answer + crc(answer))
            except OSError:
                return
            responses += 1
            if responses == self.closes_after:
                return
