// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Function 17h on a register whose second word is the switch of the EEPROM.
// EXPECT: a setting of the line, of the word order or of the memory is written by write()
// MEND: (void)io.write<basin::wide>(5u);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write_then_read<servobus::rows<basin::options>, basin::wide>(5u); // wrong
}
