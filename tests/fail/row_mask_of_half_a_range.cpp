// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A change of the highest bit of a signed register that is never negative.
// EXPECT: function 16h could take this register out of its range
// MEND: (void)io.write<tank::depth>(5);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.change_bits<tank::depth, 0x8000>(0x8000); // wrong
}
