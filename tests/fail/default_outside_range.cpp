// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row whose default lies outside its range.
// EXPECT: a_register_default_lies_inside_its_range
// MEND: inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{0x3000, {1,
// 100}, servobus::no_unit, 1};
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{
    0x3000, {1, 100}, servobus::no_unit, 0}; // wrong

int main() {
    some_drive drive;
    (void)drive.read<gain>();
}
