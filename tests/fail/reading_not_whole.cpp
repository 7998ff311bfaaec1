// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A reading asked for in a coarser unit, without rounding.
// EXPECT: a count is no whole number of this unit: use rounded()
// MEND: (void)drive.read<zlac::bus_voltage>()->rounded(units::volt);
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<zlac::bus_voltage>()->in(units::volt); // wrong
}
