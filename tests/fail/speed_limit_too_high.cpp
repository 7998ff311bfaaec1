// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A limit of speed that is no limit: 350 m/s.
// EXPECT: a_limit_of_speed_is_below_67_m_per_s
// MEND: (void)differential::of(base, units::r_per_min, 320);
#include "program.hpp"

#include "chassis.hpp"

int main() {
    (void)differential::of(base, units::r_per_min, 32'200); // wrong
}
