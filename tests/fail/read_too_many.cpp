// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read request of more registers than a frame holds.
// EXPECT: a_read_asks_for_1_to_125_registers_inside_the_address_space
// MEND: constexpr auto request = servobus::modbus::read_frame(1, 0x2000, 125);
#include "program.hpp"

int main() {
    constexpr auto request = servobus::modbus::read_frame(1, 0x2000, 126); // wrong
}
