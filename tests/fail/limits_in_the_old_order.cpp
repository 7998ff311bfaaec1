// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Limits of a travel whose highest place stands first.
// EXPECT: the_lowest_place_stands_before_the_highest
// MEND: constexpr servobus::limit_travel limits{-500 * units::pulse, 40'000 * units::pulse};
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    constexpr servobus::limit_travel limits{40'000 * units::pulse, -500 * units::pulse}; // wrong
    (void)stepper.run(limits);
}
