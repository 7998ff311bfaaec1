// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that writes more words than a routine takes.
// EXPECT: a_step_writes_at_most_6_words
// MEND: inline constexpr servobus::step zero = servobus::steps::write_zero<zlac::left_target_position,
// zlac::right_target_position>();
#include "program.hpp"

inline constexpr servobus::step zero =
    servobus::steps::write_zero<zlac::left_target_position, zlac::right_target_position, zlac::left_max_speed,
                                zlac::right_max_speed, zlac::left_target_torque,
                                zlac::right_target_torque>(); // wrong

int main() {}
