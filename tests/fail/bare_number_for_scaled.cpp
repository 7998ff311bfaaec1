// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bare number for a register whose count is not one of its unit: 15 could be meant as 15 A or as 1.5 A.
// EXPECT: this register is scaled: give a quantity, or a count by raw()
// MEND: (void)drive.write<zlac::left_rated_current>(1500 * units::milliampere);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_rated_current>(15); // wrong
}
