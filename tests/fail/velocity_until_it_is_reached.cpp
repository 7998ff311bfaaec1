// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A speed that the program waits for as for a place.
// EXPECT: a speed has no target, so nothing waits until it is reached
// MEND: (void)stepper.run(servobus::velocity{60 * units::r_per_min});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(servobus::velocity{60 * units::r_per_min}, servobus::wait_reached{}); // wrong
}
