// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that waits until a 32-bit register is near zero: it compares signed words.
// EXPECT: a_step_compares_16_bits_of_registers_of_one_word
// MEND: inline constexpr servobus::step near_zero = servobus::steps::until_within<zlac::left_actual_speed>(20, 100);
#include "program.hpp"

inline constexpr servobus::step near_zero =
    servobus::steps::until_within<zlac::left_actual_position>(20, 100); // wrong

int main() {}
