// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with a function that writes registers, and without a register that clients write.
// EXPECT: functions 16h and 17h need holding registers that clients read and write
// MEND: (void)servobus::request_executor<tank_values, servobus::with_mask_write>{values};
#include "served.hpp"

using inputs = servobus::row_values<tank::flow, tank::valve>;

int main() {
    inputs values;
    (void)servobus::request_executor<inputs, servobus::with_mask_write>{values}; // wrong
}
