// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wheel that rolls more in a turn than fits 32 bits of nm.
// EXPECT: a_turn_travels_more_than_0_and_less_than_4_29_m
// MEND: (void)rolling(4.2_m, counts_per_turn{16384});
#include "chassis.hpp"

int main() {
    (void)rolling(4.3_m, counts_per_turn{16384}); // wrong
}
