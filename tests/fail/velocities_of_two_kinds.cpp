// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The speeds of two wheels, one of which is a length in a time.
// EXPECT: this drive has no such command: it counts another kind of quantity
// MEND: (void)wheels.run(servobus::velocity{30 * units::r_per_min, 40 * units::r_per_min});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(servobus::velocity{30 * units::r_per_min, 5 * units::micrometre_per_second}); // wrong
}
