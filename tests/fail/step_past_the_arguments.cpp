// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that takes more words than are left of the routine's arguments.
// EXPECT: a_step_takes_its_words_from_the_6_arguments
// MEND: inline constexpr servobus::step speeds = servobus::steps::write_arguments<zlac::left_target_speed,
// zlac::right_target_speed>(4);
#include "program.hpp"

inline constexpr servobus::step speeds =
    servobus::steps::write_arguments<zlac::left_target_speed, zlac::right_target_speed>(5); // wrong

int main() {}
