// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A character for the number of a segment.
// EXPECT: a bool or a character is no number: give an integer
// MEND: (void)stepper.run(yako::set_speed_segment{16, 60 * units::r_per_min});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::set_speed_segment{'5', 60 * units::r_per_min}); // wrong
}
