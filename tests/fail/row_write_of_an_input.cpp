// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of a discrete input.
// EXPECT: this bit is read-only
// MEND: (void)io.read<basin::is_full>();
#include "basin.hpp"

int main() {
    some_basin io;
    (void)io.write<basin::is_full>(true); // wrong
}
