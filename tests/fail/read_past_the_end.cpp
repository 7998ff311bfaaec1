// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read request that runs past the last address.
// EXPECT: a_read_asks_for_1_to_125_registers_inside_the_address_space
// MEND: constexpr auto request = servobus::modbus::read_frame(1, 0xFFFF, 1);
#include "program.hpp"

int main() {
    constexpr auto request = servobus::modbus::read_frame(1, 0xFFFF, 2); // wrong
}
