// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step over registers that are not adjacent: a step is one frame.
// EXPECT: a_step_is_of_adjacent_registers
// MEND: inline constexpr servobus::step wait_standstill = servobus::steps::expect_zero<zlac::left_target_speed,
// zlac::right_target_speed>();
#include "program.hpp"

inline constexpr servobus::step wait_standstill =
    servobus::steps::expect_zero<zlac::left_target_speed, zlac::left_target_torque>(); // wrong

int main() {}
