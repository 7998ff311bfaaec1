// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A speed of the machine for a drive that has no axis.
// EXPECT: this drive has no such command
// MEND: (void)wheels.run(servobus::velocity{30 * units::r_per_min, 30 * units::r_per_min});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(servobus::velocity{50 * units::millimetre_per_second}); // wrong
}
