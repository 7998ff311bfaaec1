// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row whose range does not fit its value's type.
// EXPECT: a_register_range_lies_inside_its_value_type
// MEND: inline constexpr servobus::reg<servobus::i16, servobus::access::rw, zlac::device> gain{0x3000, {-1,
// 100}, servobus::no_unit, 0};
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{
    0x3000, {-1, 100}, servobus::no_unit, 0}; // wrong

int main() {
    some_drive drive;
    (void)drive.read<gain>();
}
