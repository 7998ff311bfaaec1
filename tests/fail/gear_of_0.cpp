// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A gear that never turns.
// EXPECT: a_gear_has_1_to_65535_turns_on_each_side
// MEND: (void)rolling(652.3_mm, counts_per_turn{16384}, gear_ratio{37, 10});
#include "chassis.hpp"

int main() {
    (void)rolling(652.3_mm, counts_per_turn{16384}, gear_ratio{37, 0}); // wrong
}
