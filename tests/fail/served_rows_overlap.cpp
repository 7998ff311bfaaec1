// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with a row inside another one, which has two registers.
// EXPECT: rows of a server overlap
// MEND: (void)servobus::row_values<tank::dose, tank::flow>{};
#include "served.hpp"

int main() {
    (void)servobus::row_values<tank::dose, tank::level>{}; // wrong
}
