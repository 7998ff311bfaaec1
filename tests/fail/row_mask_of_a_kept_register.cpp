// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A change of bits of a register that the device keeps in its EEPROM.
// EXPECT: every write of this register wears the drive's EEPROM
// MEND: (void)io.store<basin::kept>(1);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.change_bits<basin::kept, 0x0003>(1); // wrong
}
