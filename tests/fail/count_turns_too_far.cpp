// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels of so few counts that one of them turns the axle by 0.5 rad.
// EXPECT: a_count_turns_the_axle_by_less_than_0_4_rad
// MEND: (void)axle::of({.left = rolling(652.3_mm, counts_per_turn{4}), .right = tyre, .track = 500_mm});
#include "chassis.hpp"

int main() {
    (void)axle::of({.left = rolling(652.3_mm, counts_per_turn{4}), .right = tyre, .track = 320_mm}); // wrong
}
