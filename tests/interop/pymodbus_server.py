# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A Modbus RTU server of pymodbus on a serial device, until it is killed: pymodbus_server.py DEVICE

It prints each register and coil that a request has changed, one a line.
"""
import logging
import sys

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.device import ModbusDeviceIdentification
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.server import StartSerialServer

from tables import BAUD, COIL_BITS, FIRST, FIRST_COIL, FIRST_INPUT, INPUT_BITS, NODE, WORDS


class Reported(ModbusSequentialDataBlock):
    def __init__(self, address, values, line):
        super().__init__(address, values)
        self.line = line

    def setValues(self, address, values):
        before = list(self.values)
        super().setValues(address, values)
        for i, value in enumerate(self.values):
            if value != before[i]:
                print(self.line % (self.address + i, value), flush=True)


logging.disable()  # it logs the exceptions that it sends
slave = ModbusSlaveContext(zero_mode=True,
                           hr=Reported(FIRST, list(WORDS), "%04X=%04X"), ir=ModbusSequentialDataBlock(FIRST, WORDS),
                           co=Reported(FIRST_COIL, list(COIL_BITS), "coil %04X=%X"),
                           di=ModbusSequentialDataBlock(FIRST_INPUT, INPUT_BITS))
identity = ModbusDeviceIdentification(info_name={"VendorName": "Interop works", "ProductCode": "T-17",
                                                 "MajorMinorRevision": "1.0", "ProductName": "Four tables",
                                                 "ModelName": "long " * 40, "UserApplicationName": "long " * 30})
StartSerialServer(context=ModbusServerContext(slaves={NODE: slave}, single=False), framer=ModbusRtuFramer,
                  identity=identity, port=sys.argv[1], baudrate=BAUD, timeout=1, ignore_missing_slaves=True)
