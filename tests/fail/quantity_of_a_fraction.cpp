// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A fraction of a unit: quantities are whole numbers, here of a finer unit.
// EXPECT: a quantity is a whole number of its unit
// MEND: (void)drive.write<zlac::host_timeout>(500 * units::millisecond);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::host_timeout>(0.5 * units::second); // wrong
}
