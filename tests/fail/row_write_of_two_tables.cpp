// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil and a register in one write.
// EXPECT: a write has rows of one table
// MEND: (void)io.write<basin::valve, basin::pump>(true, false);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::valve, basin::ramp>(true, 5); // wrong
}
