// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value that may be none, used as a number.
// EXPECT: maybe
// MEND: const servobus::i32 watts = meter.read<meters::power>()->value_or({}).count();
#include "meters.hpp"

int main() {
    some_meters io;
    const servobus::i32 watts = io.read<meters::power>()->count(); // wrong
}
