// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quantity beyond the register's range, once it is in the register's counts.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)drive.write<zlac::left_max_current>(30 * units::ampere);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_current>(31 * units::ampere); // wrong
}
