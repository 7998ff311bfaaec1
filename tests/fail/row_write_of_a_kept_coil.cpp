// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of a coil that the device keeps in its EEPROM.
// EXPECT: every write of this coil wears the device's EEPROM: store() it
// MEND: (void)io.store<basin::night_light>(true);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::night_light>(true); // wrong
}
