// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of several registers, one of another device.
// EXPECT: a read has registers of one device
// MEND: (void)drive.read<zlac::bus_voltage, zlac::status_word>();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.read<zlac::bus_voltage, other::speed>(); // wrong
}
