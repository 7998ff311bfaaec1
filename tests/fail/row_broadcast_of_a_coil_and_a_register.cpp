// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A broadcast of a coil and a register.
// EXPECT: a broadcast has one register, or adjacent coils
// MEND: (void)io.broadcast<basin::valve, basin::pump>(true, false);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.broadcast<basin::valve, basin::ramp>(true, 5); // wrong
}
