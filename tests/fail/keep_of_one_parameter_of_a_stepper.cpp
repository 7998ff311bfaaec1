// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A single parameter is kept by a stepper, which keeps all its parameters together.
// EXPECT: this drive keeps all its parameters together: set this one, then save{}
// MEND: (void)stepper.run(yako::save{});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::keep<yako::base_current>{40 * units::percent}); // wrong
}
