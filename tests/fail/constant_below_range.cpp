// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A constant below the register's range.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)drive.write<zlac::left_max_speed>(1);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_speed>(0); // wrong
}
