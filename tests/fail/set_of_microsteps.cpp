// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The microsteps, on which all positions depend, are set by their row.
// EXPECT: the microsteps are set by set_microsteps{}
// MEND: (void)stepper.run(yako::set_microsteps{2000});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::set<yako::microstep_resolution>{2000}); // wrong
}
