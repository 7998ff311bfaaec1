// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A parameter that a command of its own sets, for both wheels, is set by its row.
// EXPECT: the ramps of both wheels are set by ramps{}
// MEND: (void)wheels.run(zlac::ramps{800 * units::millisecond, 500 * units::millisecond});
#include "drives.hpp"

int main() {
    some_wheels wheels;
    (void)wheels.run(zlac::set<zlac::left_acceleration_time>{800}); // wrong
}
