// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A function for a row that clients write.
// EXPECT: a computed row is read-only
// MEND: (void)servobus::row_values<servobus::computed<tank::flow, tank::measured_flow>>{};
#include "served.hpp"

int main() {
    (void)servobus::row_values<servobus::computed<tank::limit, tank::measured_flow>>{}; // wrong
}
