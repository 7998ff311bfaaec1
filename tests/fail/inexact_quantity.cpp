// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quantity that is no whole number of the register's counts of 0.1 A.
// EXPECT: this_quantity_is_no_whole_number_of_the_register_s_counts
// MEND: (void)drive.write<zlac::left_rated_current>(1500 * units::milliampere);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_rated_current>(1550 * units::milliampere); // wrong
}
