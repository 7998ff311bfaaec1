// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The Arduino port in a sketch.
#include "tests/ports/program.hpp" // first: the core has macros called min and max

#include "examples/ports/arduino_stream.hpp"

extern Stream& serial1;

bool job() {
    servobus::ports::arduino_stream rs485{serial1, 2, 115200};
    rs485.start();
    return program::count_up(rs485);
}
