// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A write of a part of a register.
// EXPECT: a part of a register is written by change_bits<R>(value): the other bits are not known
// MEND: (void)meter.change_bits<meters::mode>(3);
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.write<meters::mode>(3); // wrong
}
