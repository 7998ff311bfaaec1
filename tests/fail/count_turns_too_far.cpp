// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels whose track is no longer than one count.
// EXPECT: a_count_turns_the_axle_by_less_than_0_4_rad
// MEND: (void)axle::of({.left = tyre, .right = tyre, .track = 400_mm});
#include "chassis.hpp"

int main() {
    (void)axle::of({.left = tyre, .right = tyre, .track = 40_um}); // wrong
}
