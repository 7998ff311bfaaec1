// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scale that is finer than its conversions: state the travel of a turn in coarser steps.
// EXPECT: a_scale_in_lowest_terms_is_below_2_32_over_at_most_2_29
// MEND: (void)servobus::scale::of(16'384, 652'195);
#include "chassis.hpp"

int main() {
    (void)servobus::scale::of(16'384, 652'194'634'891); // wrong
}
