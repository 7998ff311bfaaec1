// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A checked value for a coil, which has no range.
// EXPECT: a coil is written as true or false
// MEND: (void)io.write<tank::valve>(is_open);
#include "tank.hpp"

int main() {
    some_tank io;
    const bool is_open = bool(io.read<tank::pump>());
    (void)io.write<tank::valve>(servobus::checked(is_open)); // wrong
}
