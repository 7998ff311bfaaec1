// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An option that a server does not have.
// EXPECT: this is no option of a server: see server/options.hpp
// MEND: (void)servobus::request_executor<tank_values, servobus::with_mask_write>{values};
#include "served.hpp"

struct mask_write {};

int main() {
    tank_values values;
    (void)servobus::request_executor<tank_values, mask_write>{values}; // wrong
}
