// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A constant outside the register's range. The error shows the range in angle brackets.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)drive.write<zlac::left_max_speed>(1000);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_speed>(1001); // wrong
}
