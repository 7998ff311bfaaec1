// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A single parameter is kept by a drive that keeps all its parameters together.
// EXPECT: this drive keeps all its parameters together: set this one, then save{}
// MEND: (void)wheels.run(zlac::save{});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::keep<zlac::left_speed_kp>{600}); // wrong
}
