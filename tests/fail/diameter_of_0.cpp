// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wheel without a diameter.
// EXPECT: a_diameter_is_above_0_and_at_most_1_36_m
// MEND: (void)servobus::diameter(207.6_mm);
#include "chassis.hpp"

int main() {
    (void)servobus::diameter(0_mm); // wrong
}
