// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that waits for bits of several 32-bit registers.
// EXPECT: a_step_compares_16_bits_of_registers_of_one_word
// MEND: inline constexpr servobus::step cleared = servobus::steps::until_bits<zlac::left_actual_position>(0xFFFF'FFFF,
// 0, 100);
#include "program.hpp"

inline constexpr servobus::step cleared =
    servobus::steps::until_bits<zlac::left_actual_position, zlac::right_actual_position>(0xFFFF'FFFF, 0,
                                                                                         100); // wrong

int main() {}
