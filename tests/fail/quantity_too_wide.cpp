// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number whose low 32 bits would fit, but it does not.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)drive.write<zlac::left_max_speed>(100 * units::r_per_min);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_speed>(4'294'967'396LL * units::r_per_min); // wrong
}
