// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped change of bits of a register that has a range.
// EXPECT: function 16h could take this register out of its range
// MEND: servobus::stepped_change_bits<some_basin, basin::options, 0x0003> bits{io};
#include "basin.hpp"

int main() {
    some_basin io;
    servobus::stepped_change_bits<some_basin, basin::ramp, 0x0003> bits{io};
    (void)bits.begin(1); // wrong
}
