// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil that is to be written only if it has another value.
// EXPECT: write_if_different is for registers: write() the coil, or read() it first
// MEND: (void)io.write<basin::valve>(true);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write_if_different<basin::valve>(true); // wrong
}
