// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bool that is limited at run time.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write<zlac::left_max_speed>(clamped(5));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_speed>(clamped(true)); // wrong
}
