// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of an input register.
// EXPECT: this register is read-only
// MEND: (void)io.read<tank::level>();
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write<tank::level>(3); // wrong
}
