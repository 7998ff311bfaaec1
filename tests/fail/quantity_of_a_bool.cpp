// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bool as the number of a quantity.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write<zlac::left_max_current>(30 * units::ampere);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_current>(true * units::ampere); // wrong
}
