// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quantity of another kind than the register: a time for a current.
// EXPECT: the quantity is of another kind than the register
// MEND: (void)drive.write<zlac::left_rated_current>(15 * units::ampere);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_rated_current>(15 * units::millisecond); // wrong
}
