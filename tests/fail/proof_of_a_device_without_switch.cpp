// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The proof that no write wears the EEPROM, of a device that keeps nothing unless told to.
// EXPECT: this device keeps writes only when told to
// MEND: (void)servo.ram_only();
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.ram_only(); // wrong
}
