// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with an option twice, of which one would have no effect.
// EXPECT: a server has each option once
// MEND: (void)servobus::request_executor<tank_values, servobus::with_mask_write>{values};
#include "served.hpp"

int main() {
    tank_values values;
    (void)servobus::request_executor<tank_values, servobus::with_mask_write, servobus::with_mask_write>{
        values}; // wrong
}
