// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bool for a number: `true` would be 1 ms.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write<zlac::left_acceleration_time>(500);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_acceleration_time>(true); // wrong
}
