// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that reads beyond the words that a routine keeps.
// EXPECT: a_step_fetches_into_the_routine_s_16_words
// MEND: inline constexpr servobus::step feedback = servobus::steps::fetch<zlac::left_actual_speed,
// zlac::right_actual_speed>(14);
#include "program.hpp"

inline constexpr servobus::step feedback =
    servobus::steps::fetch<zlac::left_actual_speed, zlac::right_actual_speed>(15); // wrong

int main() {}
