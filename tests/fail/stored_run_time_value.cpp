// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device that sets a register with a range to a run-time value. These are the compiler's words.
// EXPECT: constant expression
// MEND: (void)values.set<tank::flow>(servobus::checked(flow));
#include "served.hpp"

int main() {
    tank_values values;
    int flow = tank::measured_flow();
    (void)values.set<tank::flow>(flow); // wrong
}
