# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A client of pymodbus with the library's server of rows, on a serial device: pymodbus_client.py DEVICE FILE

It notes what it changes in a file, a register or a coil a line.
"""
import sys

from pymodbus.client import ModbusSerialClient
from pymodbus.diag_message import ReturnQueryDataRequest
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.mei_message import ReadDeviceInformationRequest
from pymodbus.other_message import ReportSlaveIdRequest

from tables import (BAUD, COIL_BITS, COILS, FIRST, FIRST_COIL, FIRST_INPUT, INPUT_BITS, INPUTS, NODE, WORDS, initial)

client = ModbusSerialClient(sys.argv[1], framer=ModbusRtuFramer, baudrate=BAUD, timeout=5)
written = open(sys.argv[2], "w", encoding="ascii")
failed = 0


def check(name, holds):
    global failed
    failed += not holds
    print(f"{'ok     ' if holds else 'FAILED '} {name}", flush=True)


def bits_of(response, count):
    return None if response.isError() else response.bits[:count]


def words_of(response):
    return None if response.isError() else response.registers


def refused(response, number):
    return response.isError() and getattr(response, "exception_code", None) == number


def coils(count=COILS):
    return bits_of(client.read_coils(FIRST_COIL, count, NODE), count)


def words(address, count):
    return words_of(client.read_holding_registers(address, count, NODE))


def reads():
    for count in (1, 8, 9, COILS):
        check(f"pymodbus reads by 01 {count}", coils(count) == COIL_BITS[:count])
    for count in (1, 8, INPUTS):
        check(f"pymodbus reads by 02 {count}",
              bits_of(client.read_discrete_inputs(FIRST_INPUT, count, NODE), count) == INPUT_BITS[:count])
    for count in (1, 125):
        check(f"pymodbus reads by 03 {count}", words(FIRST, count) == WORDS[:count])
        check(f"pymodbus reads by 04 {count}",
              words_of(client.read_input_registers(FIRST, count, NODE)) == WORDS[:count])


def writes():
    for is_on in (True, False):
        check(f"pymodbus writes by 05 {is_on}",
              not client.write_coil(FIRST_COIL, is_on, NODE).isError() and coils(1) == [is_on])
        print(f"coil {FIRST_COIL:04X}={is_on:X}", file=written)
    wanted = [i % 2 == 1 for i in range(COILS)]
    check(f"pymodbus writes by 0F {COILS}",
          not client.write_coils(FIRST_COIL, wanted, NODE).isError() and coils() == wanted)
    for i in range(COILS):
        if wanted[i] != COIL_BITS[i]:
            print(f"coil {FIRST_COIL + i:04X}={wanted[i]:X}", file=written)
    check("pymodbus writes by 06",
          not client.write_register(FIRST + 20, 0x5A14, NODE).isError() and words(FIRST + 20, 1) == [0x5A14])
    print("2014=5A14", file=written)
    many = [0x3C00 + i for i in range(123)]
    check("pymodbus writes by 10h 123",
          not client.write_registers(FIRST + 60, many, NODE).isError() and words(FIRST + 60, 123) == many)
    for i, word in enumerate(many):
        print(f"{FIRST + 60 + i:04X}={word:04X}", file=written)
    masked = initial(FIRST + 30) & 0xF0FF | 0x0500
    check("pymodbus changes bits by 16h",
          not client.mask_write_register(FIRST + 30, 0xF0FF, 0x0500, unit=NODE).isError()
          and words(FIRST + 30, 1) == [masked])
    print(f"201E={masked:04X}", file=written)
    both = client.readwrite_registers(read_address=FIRST + 40, read_count=2, write_address=FIRST + 41,
                                      write_registers=[0xBEEF], unit=NODE)
    check("pymodbus writes and reads by 17h", words_of(both) == [initial(FIRST + 40), 0xBEEF])
    print("2029=BEEF", file=written)


def exceptions():
    check("01: exception 2", refused(client.read_coils(FIRST_COIL + COILS, 1, NODE), 2))
    check("02: exception 2", refused(client.read_discrete_inputs(FIRST_INPUT + INPUTS - 1, 2, NODE), 2))
    check("05: exception 2", refused(client.write_coil(0, True, NODE), 2))
    check("10h: exception 2", refused(client.write_registers(0x3000, [1, 2], NODE), 2))
    check("16h: exception 2", refused(client.mask_write_register(0x3000, 0, 0, unit=NODE), 2))
    check("07: exception 1", refused(client.read_exception_status(NODE), 1))


def describes():
    answer = client.execute(ReportSlaveIdRequest(unit=NODE))
    check("pymodbus reads the ID by 11h", not answer.isError() and answer.identifier[:6] == b"tables")
    echo = client.execute(ReturnQueryDataRequest(0x1234, unit=NODE))
    check("pymodbus tests the line by 08h", not echo.isError() and list(echo.message) == [0x1234])
    for read_code, last in ((1, 2), (2, 4), (3, 0x80)):
        answer = client.execute(ReadDeviceInformationRequest(read_code, 0, unit=NODE))
        found = {} if answer.isError() else answer.information
        check(f"pymodbus reads the identification by 2Bh/0Eh, code {read_code}",
              found.get(0) == b"Interop works" and found.get(1) == b"T-17" and max(found) == last)
    single = client.execute(ReadDeviceInformationRequest(4, 4, unit=NODE))
    check("pymodbus reads one object by 2Bh/0Eh", not single.isError() and single.information == {4: b"Four tables"})


check("pymodbus opens the line", client.connect())
reads()
exceptions()
writes()
describes()
written.close()
sys.exit(failed != 0)
