// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A part of a unit as a value: 2301 * (volt / 10) is a unit.
// EXPECT: a unit is no value: 12.5 V is 125 * part<10>(volt)
// MEND: (void)drive.write<zlac::left_max_current>(125 * servobus::part<10>(units::ampere));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_current>(125 * (units::ampere / 10)); // wrong
}
