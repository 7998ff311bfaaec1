// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write to a register that can only be read.
// EXPECT: this register is read-only
// MEND: (void)drive.read<zlac::bus_voltage>();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::bus_voltage>(raw(4800)); // wrong
}
