// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number for a coil.
// EXPECT: a coil is written as true or false
// MEND: (void)io.write<tank::valve>(true);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write<tank::valve>(1); // wrong
}
