// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An array of registers that ends beyond the address space.
// EXPECT: an_array_ends_inside_the_address_space
// MEND: inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw,
// zlac::device>, 8> ends{{0xFFF0, servobus::full<servobus::u32>, servobus::no_unit, 0}, 2};
#include "program.hpp"

inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw, zlac::device>, 8>
    ends{{0xFFF0, servobus::full<servobus::u32>, servobus::no_unit, 0}, 4}; // wrong

int main() {}
