// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A change of bits of a register without a mask.
// EXPECT: change_bits<R>(value) is for a part of a register: name the bits, change_bits<R, mask>(value)
// MEND: (void)meter.change_bits<meters::mode_and_level, 0x000F>(3);
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.change_bits<meters::mode_and_level>(3); // wrong
}
