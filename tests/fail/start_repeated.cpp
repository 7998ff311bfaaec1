// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A step that may be repeated although it starts the motor.
// EXPECT: a_repeatable_step_stops_the_drive_see_stop_words
// MEND: inline constexpr servobus::step start =
// servobus::steps::write<zlac::control_word>(zlac::control_code::start_both);
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

inline constexpr servobus::step start = servobus::steps::repeatable(
    servobus::steps::write<zlac::control_word>(zlac::control_code::start_both)); // wrong

int main() {}
