// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil and a register in one write.
// EXPECT: a write has rows of one table
// MEND: (void)io.write<tank::valve, tank::pump>(true, false);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write<tank::valve, tank::ramp>(true, 5); // wrong
}
