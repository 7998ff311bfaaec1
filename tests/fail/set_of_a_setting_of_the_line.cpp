// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The address of a drive is set by its row, after which the facade would not find it.
// EXPECT: a setting of the line is no parameter
// MEND: (void)change_address<zlac::node_address>(drive, 9);
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::node_address>{9}); // wrong
}
