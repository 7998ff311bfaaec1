// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device that sets its own register to a constant out of range.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: (void)values.set<tank::flow>(1000);
#include "served.hpp"

int main() {
    tank_values values;
    (void)values.set<tank::flow>(1001); // wrong
}
