// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels without a distance between them.
// EXPECT: a_track_is_at_least_1_mm_and_less_than_16_m
// MEND: (void)axle::of({.left = tyre, .right = tyre, .track = 500_mm});
#include "chassis.hpp"

int main() {
    (void)axle::of({.left = tyre, .right = tyre, .track = 0_mm}); // wrong
}
