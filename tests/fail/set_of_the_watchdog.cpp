// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A watchdog's time, whose effect the facade must know, is set by its row.
// EXPECT: the watchdog's time is set by watchdog{}
// MEND: (void)wheels.run(zlac::watchdog{500 * units::millisecond});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::host_timeout>{500}); // wrong
}
