// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A change of the highest bit of a signed register that is never negative.
// EXPECT: function 16h could take this register out of its range
// MEND: (void)io.write<basin::depth>(5);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.change_bits<basin::depth, 0x8000>(0x8000); // wrong
}
