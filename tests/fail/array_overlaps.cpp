// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An array of two-word registers whose elements overlap.
// EXPECT: elements_of_an_array_do_not_overlap
// MEND: inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw,
// zlac::device>, 8> places{{0x3000, servobus::full<servobus::u32>, servobus::no_unit, 0}, 2};
#include "program.hpp"

inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw, zlac::device>, 8>
    places{{0x3000, servobus::full<servobus::u32>, servobus::no_unit, 0}, 1}; // wrong

int main() {}
