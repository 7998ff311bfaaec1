// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number for a coil.
// EXPECT: a coil is written as true or false
// MEND: (void)io.write<basin::valve>(true);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::valve>(1); // wrong
}
