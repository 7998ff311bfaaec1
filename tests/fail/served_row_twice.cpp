// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with a row twice.
// EXPECT: a server has each row once
// MEND: (void)servobus::row_values<tank::flow, tank::limit>{};
#include "served.hpp"

int main() {
    (void)servobus::row_values<tank::flow, tank::limit, tank::flow>{}; // wrong
}
