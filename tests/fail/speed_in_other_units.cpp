// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's count of speed that is no part of r/min.
// EXPECT: a_count_of_speed_is_of_r_per_min
// MEND: (void)differential::of(base, units::r_per_min, 300);
#include "program.hpp"

#include "chassis.hpp"

int main() {
    (void)differential::of(base, units::hertz, 300); // wrong
}
