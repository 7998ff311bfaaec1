// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A coil of a device that is set to a number.
// EXPECT: a coil or an input is set to true or false, not to a number
// MEND: (void)values.set<tank::valve>(true);
#include "served.hpp"

int main() {
    tank_values values;
    (void)values.set<tank::valve>(1); // wrong
}
