// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A take-over of an open loop stepper with a setting of a closed loop one.
// EXPECT: this command belongs to the other variant of the drive
// MEND: (void)stepper.run(servobus::take_over{servobus::disable{}, yako::save{}});
#include <servobus/control/take_over.hpp>

#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(servobus::take_over{yako::closed_loop::set_outputs{}}); // wrong
}
