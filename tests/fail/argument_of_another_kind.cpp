// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An argument of a command listed with a register of another kind: a time for a speed.
// EXPECT: the quantity is of another kind than the register
// MEND: (void)servobus::commands::argument<zlac::left_max_speed>(60 * units::r_per_min);
#include <servobus/control/arguments.hpp>

#include "program.hpp"

int main() {
    (void)servobus::commands::argument<zlac::left_acceleration_time>(60 * units::r_per_min); // wrong
}
