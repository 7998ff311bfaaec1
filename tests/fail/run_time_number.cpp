// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number that only the running program knows, without saying what becomes of it out of range. These are
// the compiler's words.
// EXPECT: constant expression
// MEND: (void)drive.write<zlac::left_max_speed>(checked(wanted));
#include "program.hpp"

int main() {
    some_drive drive;
    int wanted = some_number();
    (void)drive.write<zlac::left_max_speed>(wanted); // wrong
}
