// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value of a row that the server does not have.
// EXPECT: the server does not have this row
// MEND: (void)values.get<tank::flow>();
#include "served.hpp"

int main() {
    const tank_values values;
    (void)values.get<tank::level>(); // wrong
}
