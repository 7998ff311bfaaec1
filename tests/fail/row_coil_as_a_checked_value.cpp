// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A checked value for a coil, which has no range.
// EXPECT: a coil is written as true or false
// MEND: (void)io.write<basin::valve>(is_open);
#include "basin.hpp"

int main() {
    some_basin io;
    const bool is_open = bool(io.read<basin::pump>());
    (void)io.write<basin::valve>(servobus::checked(is_open)); // wrong
}
