// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A part that is set to more than its bits hold.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)meter.change_bits<meters::mode>(15);
#include "meters.hpp"

int main() {
    some_meters io;
    (void)io.change_bits<meters::mode>(16); // wrong
}
