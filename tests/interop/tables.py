# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What both servers have at the start and both clients expect: as registers.hpp."""
NODE = 17
FIRST, COUNT = 0x2000, 200
FIRST_COIL, COILS = 0x0010, 17
FIRST_INPUT, INPUTS = 0x0040, 11
BAUD = 115200


def initial(address):
    return address * 40503 >> 3 & 0xFFFF


def initial_bit(address):
    return address % 3 == 0


WORDS = [initial(FIRST + i) for i in range(COUNT)]
COIL_BITS = [initial_bit(FIRST_COIL + i) for i in range(COILS)]
INPUT_BITS = [initial_bit(FIRST_INPUT + i) for i in range(INPUTS)]
