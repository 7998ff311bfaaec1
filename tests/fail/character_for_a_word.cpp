// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A character for a register without a row.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)drive.write_word(0x2100, 5);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write_word(0x2100, U'5'); // wrong
}
