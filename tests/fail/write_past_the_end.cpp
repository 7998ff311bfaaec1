// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write request that runs past the last address.
// EXPECT: a_write_has_1_to_123_registers_inside_the_address_space
// MEND: constexpr auto request = servobus::modbus::write_frame(1, 0xFFFE, words);
#include <array>

#include "program.hpp"

int main() {
    constexpr std::array<std::uint16_t, 2> words{1, 2};
    constexpr auto request = servobus::modbus::write_frame(1, 0xFFFF, words); // wrong
}
