// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A segment that the drive does not have.
// EXPECT: segments_are_numbered_1_to_16
// MEND: (void)stepper.run(yako::set_speed_segment{16, 60 * units::r_per_min});
#include "stepper.hpp"

int main() {
    some_stepper stepper;
    (void)stepper.run(yako::set_speed_segment{17, 60 * units::r_per_min}); // wrong
}
