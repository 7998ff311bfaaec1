// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of coils that do not lie side by side.
// EXPECT: a write of several coils is one frame: they must be adjacent and in address order
// MEND: (void)io.write<tank::pump>(true);
#include "tank.hpp"

int main() {
    some_tank io;
    (void)io.write<tank::pump, tank::lamp>(true, true); // wrong
}
