# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The simulated device of a file: what it answers is compared with a second implementation, in this file."""
import os
import random
import select
import struct
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import crc, packed
from programs import Tool, play_tool, scene

PLANT = """# name = plant
# baud = 115200
# max_read = 20
# max_write = 10
# word_order = low
address,name,table,type,access,min,max,default,word_order,unit,scale
0,pump,coil,bool,rw,,,1,,,
1,valve,coil,bool,rw,,,0,,,
2,lamp,coil,bool,ro,,,1,,,
8,horn,coil,bool,rw,,,,,,
4,door,discrete,bool,,,,1,,,
5,level_high,discrete,bool,,,,,,,
0x30,level,input,u16,ro,,,4711,,,
0x31,volume,input,u32,ro,,,70000,,,
0x10,setpoint,holding,u16,rw,5,900,,,V,0.1
0x11,offset,holding,i16,rw,-50,50,-7,,,
0x12,position,holding,i32,rw,-100000,100000,-70000,high,,
0x14,total,holding,u32,rw,,,70000,,,
0x16,key,holding,u16,wo,,,,,,
0x17,state,holding,u16,ro,,,3,,,
"""
# Table, address, words, access, least, most, value, high word first.
ROWS = [
    ("c", 0, 1, "rw", 0, 1, 1, True), ("c", 1, 1, "rw", 0, 1, 0, True), ("c", 2, 1, "ro", 0, 1, 1, True),
    ("c", 8, 1, "rw", 0, 1, 0, True), ("d", 4, 1, "ro", 0, 1, 1, True), ("d", 5, 1, "ro", 0, 1, 0, True),
    ("i", 0x30, 1, "ro", 0, 65535, 4711, True), ("i", 0x31, 2, "ro", 0, 2**32 - 1, 70000, False),
    ("h", 0x10, 1, "rw", 5, 900, 5, True), ("h", 0x11, 1, "rw", -50, 50, -7, True),
    ("h", 0x12, 2, "rw", -100000, 100000, -70000, True), ("h", 0x14, 2, "rw", 0, 2**32 - 1, 70000, False),
    ("h", 0x16, 1, "wo", 0, 65535, 0, True), ("h", 0x17, 1, "ro", 0, 65535, 3, True),
]
TABLES = {1: "c", 2: "d", 3: "h", 4: "i", 5: "c", 6: "h", 15: "c", 16: "h"}


class Plant:
    """What the file says, word by word, and the standard."""

    def __init__(self):
        self.words: dict[tuple[str, int], int] = {}
        self.row_at = {}
        for row in ROWS:
            table, address, words, _, _, _, value, is_high_first = row
            raw = [value & 0xFFFF] if words == 1 else [value >> 16 & 0xFFFF, value & 0xFFFF][:: 1 if is_high_first else -1]
            for i, word in enumerate(raw):
                self.words[table, address + i] = word
                self.row_at[table, address + i] = row

    def is_whole(self, table: str, first: int, count: int, access: str) -> bool:
        rows = [self.row_at.get((table, first + i)) for i in range(count)]
        if any(row is None or row[3] == access for row in rows):
            return False
        return all(row[1] >= first and row[1] + row[2] <= first + count for row in rows)

    def respond(self, pdu: bytes) -> bytes:
        code = pdu[0]

        def refused(number: int) -> bytes:
            return bytes([code | 0x80, number])

        if code not in TABLES:
            return refused(1)
        table = TABLES[code]
        first, count = struct.unpack(">HH", pdu[1:5])
        if code <= 4:
            if not 1 <= count <= (2000 if code <= 2 else 20):
                return refused(3)
            if not self.is_whole(table, first, count, "wo"):
                return refused(2)
            words = [self.words[table, first + i] for i in range(count)]
            data = packed([word != 0 for word in words]) if code <= 2 else struct.pack(f">{count}H", *words)
            return bytes([code, len(data)]) + data
        if code == 5:
            if count not in (0, 0xFF00):
                return refused(3)
            count, words = 1, [int(count != 0)]
        elif code == 6:
            count, words = 1, [count]
        else:
            size = (count + 7) // 8 if code == 15 else 2 * count
            if not 1 <= count <= (1968 if code == 15 else 10) or pdu[5] != size or len(pdu) != 6 + size:
                return refused(3)
            words = ([pdu[6 + i // 8] >> i % 8 & 1 for i in range(count)] if code == 15 else
                     list(struct.unpack(f">{count}H", pdu[6:])))
        if not self.is_whole(table, first, count, "ro"):
            return refused(2)
        at = 0
        while at < count:
            _, address, size, _, least, most, _, is_high_first = self.row_at[table, first + at]
            raw = words[at: at + size]
            value = raw[0] if size == 1 else (raw[0] << 16 | raw[1] if is_high_first else raw[1] << 16 | raw[0])
            if least < 0 and value >= 1 << (16 * size - 1):
                value -= 1 << 16 * size
            if not least <= value <= most:
                return refused(3)
            at += size
        for i, word in enumerate(words):
            self.words[table, first + i] = word
        return pdu[:5]


def random_pdu(r: random.Random) -> bytes:
    code = r.choice([1, 2, 3, 3, 4, 4, 5, 6, 6, 15, 16, 16, 16, 7])
    rows = [row for row in ROWS if row[0] == TABLES.get(code)] if r.random() < 0.8 else ROWS
    address = max((r.choice(rows) if rows else ROWS[0])[1] + r.choice([0] * 6 + [1, -1]), 0)
    count = r.choice([1, 1, 2, 2, 3, 4, 6, 0, 21, 2001, 11])
    value = r.choice([0, 1, 5, 4, 900, 901, 0xFFF9, 50, 51, 0xFFCD, 0xFFFF, 0xFF00])
    if code == 7:
        return b"\7"
    if code <= 4:
        return struct.pack(">BHH", code, address, count)
    if code <= 6:
        return struct.pack(">BHH", code, address, value)
    count = min(count, 12)
    data = bytes(r.randrange(256) for _ in range((count + 7) // 8)) if code == 15 else b"".join(
        struct.pack(">H", r.choice([0, 0, 0, 1, 5, 7, 0xFFFF, 0xFFFE, 0x8000])) for _ in range(count))
    return struct.pack(">BHHB", code, address, count, len(data)) + data


def exchange(port: int, node: int, pdu: bytes, has_response: bool) -> bytes:
    """The PDU of the response; empty if there is none."""
    frame = bytes([node]) + pdu
    os.write(port, frame + crc(frame))
    came = b""
    end = time.monotonic() + (5 if has_response else 0.05)
    while time.monotonic() < end:
        if select.select([port], [], [], 0.01)[0]:
            came += os.read(port, 512)
        if len(came) > 3 and crc(came[:-2]) == came[-2:]:
            break
    return came[1:-2]


@scene()
def answers_as_its_file_says(tool: Tool):
    tool.write("plant.csv", PLANT)
    with tool.simulated("plant.csv --node 3"):
        port = os.open(tool.folder / "drive", os.O_RDWR | os.O_NOCTTY)
        plant, r, kinds = Plant(), random.Random(41), Counter()
        wrong = []
        for _ in range(700):
            pdu = random_pdu(r)
            expected = plant.respond(pdu)
            found = exchange(port, 3, pdu, True)
            kinds[pdu[0], expected[1] if expected[0] & 0x80 else 0] += 1
            if found != expected:
                wrong.append(f"{pdu.hex(' ')}: expected {expected.hex(' ')}, found {found.hex(' ')}")
        tool.check("700 requests as by a second implementation", not wrong, "\n".join(wrong[:5]))
        for code in (1, 2, 3, 4, 5, 6, 15, 16):
            outcomes = (0, 2) if code == 6 else (0, 2, 3)
            for number in outcomes:
                tool.check(f"function {code:02X}, {'done' if number == 0 else f'exception {number}'}, was played",
                           kinds[code, number] >= 2, str(kinds))
        tool.check("and a function that it does not have", kinds[7, 1] >= 2)
        exchange(port, 3, struct.pack(">BHH", 6, 0x10, 100), True)
        tool.check("to all: without a response", exchange(port, 0, struct.pack(">BHH", 6, 0x10, 200), False) == b"")
        tool.check("but done", exchange(port, 3, struct.pack(">BHH", 3, 0x10, 1), True) == b"\3\2\0\xC8")
        tool.check("a read to all does nothing", exchange(port, 0, struct.pack(">BHH", 3, 0x10, 1), False) == b"")
        tool.check("nor a request to another", exchange(port, 4, struct.pack(">BHH", 6, 0x10, 300), False) == b"")
        os.close(port)
        tool.says("and by the tool", "read drive plant.csv:3 setpoint position total volume",
                  "setpoint=20.0 V", f"position={value_of(plant, 'h', 0x12, True)}",
                  f"total={value_of(plant, 'h', 0x14, False)}", "volume=70000")


def value_of(plant: Plant, table: str, address: int, is_high_first: bool) -> int:
    words = [plant.words[table, address + i] for i in range(2)][:: 1 if is_high_first else -1]
    value = words[0] << 16 | words[1]
    return value - (1 << 32) if is_high_first and value >= 1 << 31 else value


@scene()
def word_order_by_a_register(tool: Tool):
    tool.write("switch.csv", "# word_order = selectable\n# word_order_register = 2\naddress,name,type,access,default,word_order\n"
               "1,count,i32,rw,-2,selectable\n".replace("1,", "4,", 1) + "2,order,u16,rw,,\n")
    with tool.simulated("switch.csv"):
        port = os.open(tool.folder / "drive", os.O_RDWR | os.O_NOCTTY)
        read = struct.pack(">BHH", 3, 4, 2)
        tool.is_equal("high word first", exchange(port, 1, read, True), bytes.fromhex("0304fffffffe"))
        exchange(port, 1, struct.pack(">BHH", 6, 2, 1), True)
        tool.is_equal("low word first", exchange(port, 1, read, True), bytes.fromhex("0304fffeffff"))
        os.close(port)
        tool.says("and the tool knows", "read drive switch.csv count", "count=-2")


@scene()
def refused(tool: Tool):
    tool.write("meter.csv", "# lowest_address = 5\n# highest_address = 9\naddress,name\n1,a\n")
    tool.fails("a node that the device cannot have", "sim meter.csv --node 4", 2, "--node")
    tool.write("meter.csv", "address,name\n1,a\n1,b\n")
    tool.fails("a file with a mistake", "sim meter.csv", 2, "meter.csv:3: b: the address 0x0001 is taken by the row in line 2")
    tool.fails("no file", "sim none.csv", 2, "cannot read none.csv")


play_tool()
