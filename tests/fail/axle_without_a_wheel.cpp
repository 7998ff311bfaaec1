// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An axle of which a wheel was left out.
// EXPECT: a_turn_has_1_to_2_28_counts
// MEND: (void)axle::of({.left = tyre, .right = tyre, .track = 500_mm});
#include "chassis.hpp"

int main() {
    (void)axle::of({.left = tyre, .track = 500_mm}); // wrong
}
