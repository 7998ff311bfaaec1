// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A parameter that only the other variant of a stepper has is set.
// EXPECT: this command belongs to the other variant of the drive
// MEND: (void)stepper.run(yako::set<yako::open_loop::max_current>{3 * units::ampere});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::set<yako::closed_loop::max_current>{3 * units::ampere}); // wrong
}
