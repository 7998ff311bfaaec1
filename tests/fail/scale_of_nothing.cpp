// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scale of which the denominator is 0.
// EXPECT: a_scale_is_a_ratio_above_0
// MEND: (void)servobus::scale::of(16'384, 652'300);
#include "chassis.hpp"

int main() {
    (void)servobus::scale::of(16'384, 0); // wrong
}
