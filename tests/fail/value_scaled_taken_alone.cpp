// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value that is taken out of a read that has not the row that scales it.
// EXPECT: another row scales this one: name both, read<power, power_exponent>()
// MEND: (void)meter.read<meters::current, meters::exponent>()->get<meters::current>();
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.read<meters::current, meters::power>()->get<meters::current>(); // wrong
}
