// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A reading asked for in a unit of another kind.
// EXPECT: the quantity is of another kind than this unit
// MEND: (void)drive.read<zlac::bus_voltage>()->rounded(units::volt);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<zlac::bus_voltage>()->in(units::ampere); // wrong
}
