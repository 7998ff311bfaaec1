// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with rows of two devices.
// EXPECT: the rows of a server belong to one device
// MEND: (void)servobus::row_values<tank::limit, tank::flow>{};
#include "served.hpp"

int main() {
    (void)servobus::row_values<tank::limit, pump::speed>{}; // wrong
}
