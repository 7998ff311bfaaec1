// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A character for a count.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write<zlac::left_target_speed>(raw(100));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_target_speed>(raw(u'd')); // wrong
}
