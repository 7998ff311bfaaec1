// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bare number for a register of names.
// EXPECT: this register takes a value of its own type
// MEND: (void)drive.write<zlac::control_word>(zlac::control_code::enable);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::control_word>(8); // wrong
}
