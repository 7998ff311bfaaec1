// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An opaque PDU on a line that knows four functions.
// EXPECT: a blocking_line has functions 03, 04, 06 and 10h only
// MEND: servobus::line wire{port, servobus::modbus::timing_at(57600)};
#include <array>

#include <servobus/line/blocking_line.hpp>

#include "program.hpp"

int main() {
    some_port port;
    servobus::blocking_line<some_port, servobus::modbus::timing_at(57600)> wire{port}; // wrong
    servobus::client drive{wire, servobus::node<zlac::device>{1}};
    const std::array<std::uint8_t, 1> request{0x11};
    std::array<std::uint8_t, 4> response{};
    (void)drive.transact(request, response);
}
