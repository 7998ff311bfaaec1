// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A take-over with a command that moves the motor, which a program gives once the drive is taken over.
// EXPECT: a take-over neither energises the motor nor moves it: run this command after it
// MEND: (void)stepper.run(servobus::take_over{servobus::disable{}, yako::save{}});
#include <servobus/control/take_over.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(servobus::take_over{yako::open_loop::home{yako::homing::home_24}}); // wrong
}
