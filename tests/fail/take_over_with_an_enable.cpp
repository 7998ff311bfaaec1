// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A take-over that would energise the motor.
// EXPECT: a take-over neither energises the motor nor moves it: run this command after it
// MEND: (void)stepper.run(servobus::take_over{servobus::disable{}, yako::save{}});
#include <servobus/control/take_over.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(servobus::take_over{servobus::enable{}, yako::save{}}); // wrong
}
