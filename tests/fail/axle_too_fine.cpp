// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels of which the ratio of counts to track has more than 62 bits: state it in coarser steps.
// EXPECT: an_axle_in_lowest_terms_is_below_2_62_counts_times_nm
// MEND: (void)axle::of({.left = rolling(652'301_um, counts_per_turn{1u << 28}), .right = tyre, .track = 500_mm});
#include "chassis.hpp"

int main() {
    (void)axle::of({.left = rolling(652'301_um, counts_per_turn{1u << 28}, gear_ratio{65521, 1}),
                    .right = tyre,
                    .track = 499'999_um}); // wrong
}
