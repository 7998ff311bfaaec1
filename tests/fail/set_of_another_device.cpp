// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A parameter of another device is set.
// EXPECT: this register belongs to another device
// MEND: (void)wheels.run(zlac::set<zlac::left_speed_kp>{600});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<servobus::c630s::positioning_completed_threshold>{600}); // wrong
}
