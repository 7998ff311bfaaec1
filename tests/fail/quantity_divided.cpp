// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quantity that is divided.
// EXPECT: a quantity is a whole number of its unit and is not divided: 12.5 V is 125 * part<10>(volt)
// MEND: (void)drive.write<zlac::left_max_current>(125 * servobus::part<10>(units::ampere));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_max_current>(125 * units::ampere / 10); // wrong
}
