// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row whose count is a tenth of nothing.
// EXPECT: a_scaled_register_has_a_unit
// MEND: inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{0x3000, {1,
// 100}, servobus::no_unit, 1};
#include "program.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain{
    0x3000, {1, 100}, servobus::no_unit / 10, 1}; // wrong

int main() {
    some_drive drive;
    (void)drive.read<gain>();
}
