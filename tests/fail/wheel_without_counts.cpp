// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wheel whose drive counts nothing.
// EXPECT: a_turn_has_1_to_2_28_counts
// MEND: (void)rolling(652.3_mm, counts_per_turn{4 * 4096});
#include "chassis.hpp"

int main() {
    (void)rolling(652.3_mm, counts_per_turn{0}); // wrong
}
