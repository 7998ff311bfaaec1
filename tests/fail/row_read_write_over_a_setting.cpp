// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Function 17h on a register whose second word is the switch of the EEPROM.
// EXPECT: a setting of the line, of the word order or of the memory is written by write()
// MEND: (void)io.write<tank::wide>(5u);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write_then_read<servobus::rows<tank::options>, tank::wide>(5u); // wrong
}
