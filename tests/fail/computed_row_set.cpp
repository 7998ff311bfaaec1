// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device that sets a row which a function computes.
// EXPECT: a function computes this row: it cannot be set
// MEND: (void)values.get<tank::flow>();
#include "served.hpp"

int main() {
    servobus::row_values<tank::limit, servobus::computed<tank::flow, tank::measured_flow>> values;
    (void)values.set<tank::flow>(5); // wrong
}
