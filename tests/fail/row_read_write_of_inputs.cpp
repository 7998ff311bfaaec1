// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Function 17h on input registers.
// EXPECT: function 17h is for holding registers
// MEND: (void)io.write_then_read<servobus::rows<tank::options>, tank::ramp>(5);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write_then_read<servobus::rows<tank::level>, tank::ramp>(5); // wrong
}
