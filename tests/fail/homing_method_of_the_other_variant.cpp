// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An open loop stepper that is to home on the index pulse of an encoder.
// EXPECT: this_drive_has_no_such_homing_method
// MEND: (void)stepper.run(yako::open_loop::home{yako::homing::home_24});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::open_loop::home{yako::homing::home_and_index_8}); // wrong
}
