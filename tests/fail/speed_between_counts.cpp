// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A constant speed that is no whole number of the drive's counts.
// EXPECT: this quantity is finer than a count of the drive: it would be rounded
// MEND: (void)servo.run(servobus::velocity{30 * units::r_per_min});
#include "drives.hpp"

int main() {
    some_servo servo;
    (void)servo.run(servobus::velocity{305 * servobus::part<10>(units::r_per_min)}); // wrong
}
