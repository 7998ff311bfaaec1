// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read that names a register twice.
// EXPECT: a read names each register once
// MEND: (void)drive.read<zlac::bus_voltage, zlac::status_word>();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<zlac::bus_voltage, zlac::bus_voltage>(); // wrong
}
