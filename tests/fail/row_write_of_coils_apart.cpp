// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of coils that do not lie side by side.
// EXPECT: a write of several coils is one frame: they must be adjacent and in address order
// MEND: (void)io.write<basin::pump>(true);
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::pump, basin::lamp>(true, true); // wrong
}
