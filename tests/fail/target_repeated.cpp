// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A target of which zero is no standstill, written by a step that may be repeated.
// EXPECT: a_repeatable_step_stops_the_drive_see_stop_words
// MEND: inline constexpr servobus::step home = servobus::steps::write_zero<zlac::left_target_position>();
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

inline constexpr servobus::step home =
    servobus::steps::repeatable(servobus::steps::write_zero<zlac::left_target_position>()); // wrong

int main() {}
