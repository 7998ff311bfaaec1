// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of a device that switches its word order, without the register that does it.
// EXPECT: the device switches its word order: its server has that register, a stored row from 0 to 1
// MEND: (void)servobus::row_values<scale::pair_word_order, scale::weight>{};
#include "served.hpp"

int main() {
    (void)servobus::row_values<scale::weight>{}; // wrong
}
