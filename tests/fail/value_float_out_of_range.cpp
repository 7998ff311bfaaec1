// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A float beyond the range of its register.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)meter.write<meters::target>(399.5f);
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.write<meters::target>(400.5f); // wrong
}
