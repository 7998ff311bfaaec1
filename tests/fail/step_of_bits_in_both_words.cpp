// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that compares bits in both words of a 32-bit register: it reads one word.
// EXPECT: bits_of_a_step_lie_in_one_word_of_its_register
// MEND: inline constexpr servobus::step low_bit = servobus::steps::expect_bits<zlac::left_actual_position>(0x0000'0001,
// 1, servobus::errc::busy);
#include "program.hpp"

inline constexpr servobus::step low_bit =
    servobus::steps::expect_bits<zlac::left_actual_position>(0x8000'0001, 1, servobus::errc::busy); // wrong

int main() {}
