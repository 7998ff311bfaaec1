// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A token for a write of an array's coil: it is for registers.
// EXPECT: a coil is written or stored without a token
// MEND: (void)io.store<basin::lamps>(2, true);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::lamps>(2, true, *io.ram_only()); // wrong
}
