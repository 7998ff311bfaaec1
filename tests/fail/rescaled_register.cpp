// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quantity for a register whose scale another register sets at run time (2022h).
// EXPECT: another register rescales this one: write it through the drive, or by raw()
// MEND: (void)drive.write<zlac::left_target_speed>(raw(100));
#include "program.hpp"

int main() {
    some_drive drive;
    (void)drive.write<zlac::left_target_speed>(100 * units::r_per_min); // wrong
}
