// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What both servers have at the start and both clients expect: as registers.hpp.
"use strict";
module.exports = {
    node: 17,
    first: 0x2000,
    count: 200,
    firstCoil: 0x0010,
    coils: 17,
    firstInput: 0x0040,
    inputs: 11,
    baud: 115200,
    initial: (address) => address * 40503 >> 3 & 0xFFFF,
    initialBit: (address) => address % 3 === 0,
};
