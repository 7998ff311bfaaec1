// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read of a value without the row that scales it.
// EXPECT: another row scales this one: name both, read<power, power_exponent>()
// MEND: (void)meter.read<meters::current, meters::exponent>();
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.read<meters::current>(); // wrong
}
