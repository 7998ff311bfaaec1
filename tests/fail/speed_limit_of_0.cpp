// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's limit of speed that lets no wheel turn.
// EXPECT: a_limit_of_speed_is_1_to_32767_counts
// MEND: (void)differential::of(base, units::r_per_min / 10, 3000);
#include "program.hpp"

#include "chassis.hpp"

int main() {
    (void)differential::of(base, units::r_per_min / 10, 0); // wrong
}
