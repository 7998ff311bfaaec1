// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A step that waits for a stop's answer, and is no stop itself.
// EXPECT: a_step_after_a_stop_is_a_stop
// MEND: inline constexpr servobus::step too = servobus::steps::after_a_stop(servobus::steps::repeatable(
//     servobus::steps::write_zero<zlac::left_target_torque, zlac::right_target_torque>()));
#include "program.hpp"

inline constexpr servobus::step too = servobus::steps::after_a_stop( // wrong
    servobus::steps::write_zero<zlac::left_target_torque, zlac::right_target_torque>());

int main() {}
