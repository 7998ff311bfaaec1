// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A target is no parameter.
// EXPECT: a target is no parameter
// MEND: (void)wheels.run(zlac::torque{500 * units::milliampere, {}});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::left_target_torque>{500}); // wrong
}
