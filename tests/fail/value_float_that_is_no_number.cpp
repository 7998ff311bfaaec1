// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A NaN as a value.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)meter.write<meters::target>(21.5f);
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.write<meters::target>(__builtin_nanf("")); // wrong
}
