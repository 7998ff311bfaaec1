// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A character that is checked at run time.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write<zlac::left_max_speed>(checked(5));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_speed>(checked(u8'5')); // wrong
}
