// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Function 17h on input registers.
// EXPECT: function 17h is for holding registers
// MEND: (void)io.write_then_read<servobus::rows<basin::options>, basin::ramp>(5);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write_then_read<servobus::rows<basin::level>, basin::ramp>(5); // wrong
}
