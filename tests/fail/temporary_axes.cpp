// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two belts whose axes end at once; the drive refers to them.
// EXPECT: deleted
// MEND: zlac::axes belts{line_of_belts, 1, belt, belt, servobus::unsupervised};
#include "belts.hpp"

int main() {
    zlac::axes belts{line_of_belts, 1, axis::of(tyre), axis::of(tyre), servobus::unsupervised}; // wrong
    (void)belts;
}
