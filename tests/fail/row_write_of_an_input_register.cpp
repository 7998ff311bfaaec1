// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of an input register.
// EXPECT: this register is read-only
// MEND: (void)io.read<basin::level>();
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::level>(3); // wrong
}
