// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A move of two wheels, given to a drive with one motor.
// EXPECT: this drive has no such command
// MEND: (void)stepper.run(servobus::move_by{400 * units::pulse});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(servobus::move_by{400 * units::pulse, 400 * units::pulse}); // wrong
}
