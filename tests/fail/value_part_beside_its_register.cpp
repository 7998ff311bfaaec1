// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of a register and of a part of it.
// EXPECT: a read names each row once
// MEND: (void)meter.read<meters::mode, meters::level>();
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.read<meters::mode, meters::mode_and_level>(); // wrong
}
