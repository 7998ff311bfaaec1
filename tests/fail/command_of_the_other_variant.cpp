// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command of a closed loop stepper, given to an open loop one.
// EXPECT: this command belongs to the other variant of the drive
// MEND: (void)stepper.run(yako::open_loop::home{yako::homing::home_24});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::closed_loop::home{yako::homing::home_24}); // wrong
}
