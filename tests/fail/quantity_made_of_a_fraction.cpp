// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A fraction in place of a count: 2.5 r/min would become 2/2520 r/min.
// EXPECT: a quantity is a whole number of its unit
// MEND: constexpr zlac::speed slow{25 * servobus::part<10>(units::r_per_min)};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

int main() {
    constexpr zlac::speed slow(2.5); // wrong
    (void)slow;
}
