// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A change of bits of a register that has a range.
// EXPECT: function 16h could take this register out of its range
// MEND: (void)io.change_bits<basin::options, 0x0003>(1);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.change_bits<basin::ramp, 0x0003>(1); // wrong
}
