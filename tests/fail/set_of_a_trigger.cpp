// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A control word is no parameter.
// EXPECT: a command of the drive writes this register
// MEND: (void)wheels.run(servobus::enable{});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::control_word>{zlac::control_code::enable}); // wrong
}
