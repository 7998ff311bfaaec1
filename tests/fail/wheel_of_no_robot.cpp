// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot of which a turn of the motor travels 6 um.
// EXPECT: a_turn_of_the_motor_travels_10_um_to_4_3_m
// MEND: (void)differential::of({.left = tyre, .right = tyre, .track = 500_mm});
#include <servobus/axis/differential.hpp>

#include "chassis.hpp"
using servobus::differential;

int main() {
    (void)differential::of({.left = rolling(0.6_mm, counts_per_turn{16384}, gear_ratio{100, 1}),
                            .right = tyre,
                            .track = 500_mm}); // wrong
}
