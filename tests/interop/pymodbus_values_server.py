# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A Modbus RTU server of pymodbus that has the values of values.hpp, encoded and decoded by pymodbus' own functions,
until it is killed: pymodbus_values_server.py DEVICE

It prints each value that a request has changed.
"""
import logging
import sys

from pymodbus.constants import Endian
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder
from pymodbus.server import StartSerialServer

from tables import BAUD, NODE

BIG = getattr(Endian, "BIG", None) or Endian.Big
LITTLE = getattr(Endian, "LITTLE", None) or Endian.Little
BLOCKS = {"high": (0x0100, BIG), "low": (0x0200, LITTLE)}
WRITTEN_BEHIND = 0x0040
# Name, place in a block, registers, the value at the start, its functions of pymodbus, the order of bytes.
VALUES = [
    ("f32", 0, 2, 230.1, "32bit_float", BIG), ("f64", 2, 4, -12.5e-30, "64bit_float", BIG),
    ("u32", 6, 2, 4000000001, "32bit_uint", BIG), ("i32", 8, 2, -70000, "32bit_int", BIG),
    ("u64", 10, 4, 0x8001000200030004, "64bit_uint", BIG), ("i64", 14, 4, -5, "64bit_int", BIG),
    ("swapped", 18, 2, -0.75, "32bit_float", LITTLE), ("text", 20, 4, "SDM120\0\0", "string", BIG),
]
FORMATS = {"f32": "%.9g", "swapped": "%.9g", "f64": "%.17g"}


def shown(words, block, order, name, place, count, kind, bytes_first):
    """A value as text."""
    own = words[block + place:block + place + count]
    # The library's word order is that of 32-bit values with the high byte first.
    decoder = BinaryPayloadDecoder.fromRegisters(own, byteorder=bytes_first, wordorder=order)
    if kind == "string":
        return decoder.decode_string(2 * count).decode().rstrip("\0")
    return FORMATS.get(name, "%d") % getattr(decoder, f"decode_{kind}")()


class Reported(ModbusSequentialDataBlock):
    def setValues(self, address, values):
        before = list(self.values)
        super().setValues(address, values)
        for order_name, (block, order) in BLOCKS.items():
            for name, place, count, _, kind, bytes_first in VALUES:
                one = (block + WRITTEN_BEHIND, order, name, place, count, kind, bytes_first)
                if shown(before, *one) != shown(self.values, *one):
                    print(order_name, name, shown(self.values, *one), flush=True)


def filled():
    words = [0] * 0x300
    for block, order in BLOCKS.values():
        for _, place, count, value, kind, bytes_first in VALUES:
            builder = BinaryPayloadBuilder(byteorder=bytes_first, wordorder=order)
            getattr(builder, f"add_{kind}")(value)
            words[block + place:block + place + count] = builder.to_registers()
    return words


logging.disable()
slave = ModbusSlaveContext(zero_mode=True, hr=Reported(0, filled()))
StartSerialServer(context=ModbusServerContext(slaves={NODE: slave}, single=False), framer=ModbusRtuFramer,
                  port=sys.argv[1], baudrate=BAUD, timeout=1, ignore_missing_slaves=True)
