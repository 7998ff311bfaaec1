// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped write of a coil that the device keeps in its EEPROM.
// EXPECT: every write of this coil wears the device's EEPROM: store() it
// MEND: servobus::stepped_store<some_basin, basin::night_light> light{io};
#include "basin.hpp"

int main() {
    some_basin io;
    servobus::stepped_write<some_basin, basin::night_light> light{io};
    (void)light.begin(true); // wrong
}
