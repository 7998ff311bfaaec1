// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A count of a float, which a NaN does not have, used as a number.
// EXPECT: maybe
// MEND: const servobus::i32 volts = meter.read<meters::voltage>()->rounded(units::volt).value_or(0);
#include "meters.hpp"

int main() {
    some_meters io;
    const servobus::i32 volts = io.read<meters::voltage>()->rounded(servobus::units::volt); // wrong
}
