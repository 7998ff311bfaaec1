// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row of two registers at the last address.
// EXPECT: a_two_word_register_ends_inside_the_address_space
// MEND: inline constexpr servobus::reg<servobus::u32, servobus::access::rw, zlac::device> gain{0xFFFE,
// servobus::full<servobus::u32>, servobus::no_unit, 0};
#include "program.hpp"

inline constexpr servobus::reg<servobus::u32, servobus::access::rw, zlac::device> gain{
    0xFFFF, servobus::full<servobus::u32>, servobus::no_unit, 0}; // wrong

int main() {
    some_drive drive;
    (void)drive.read<gain>();
}
