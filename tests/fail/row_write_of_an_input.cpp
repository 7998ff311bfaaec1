// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of a discrete input.
// EXPECT: this bit is read-only
// MEND: (void)io.read<tank::is_full>();
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write<tank::is_full>(true); // wrong
}
