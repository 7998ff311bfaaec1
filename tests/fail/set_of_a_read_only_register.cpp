// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register that can only be read is set.
// EXPECT: this register is read-only
// MEND: (void)drive.read<zlac::bus_voltage>();
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::bus_voltage>{checked(2400)}); // wrong
}
