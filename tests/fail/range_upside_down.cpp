// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row whose lowest value is above its highest.
// EXPECT: a_register_range_is_low_to_high
// MEND: inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{0x3000, {1,
// 100}, servobus::no_unit, 1};
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{
    0x3000, {100, 1}, servobus::no_unit, 1}; // wrong

int main() {
    some_drive drive;
    (void)drive.read<gain>();
}
