// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that writes a register which can only be read.
// EXPECT: a_step_writes_no_read_only_register
// MEND: inline constexpr servobus::step zero_speed = servobus::steps::write_zero<zlac::left_target_speed>();
#include "program.hpp"

inline constexpr servobus::step zero_speed = servobus::steps::write_zero<zlac::left_actual_speed>(); // wrong

int main() {}
