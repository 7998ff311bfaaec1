// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that compares 32-bit registers by a mask of 16 bits.
// EXPECT: a_step_compares_16_bits_of_registers_of_one_word
// MEND: inline constexpr servobus::step at_zero = servobus::steps::expect_zero<zlac::left_target_position>(
// servobus::errc::busy);
#include "program.hpp"

inline constexpr servobus::step at_zero =
    servobus::steps::expect_zero<zlac::left_target_position>(servobus::errc::busy, 0x00FF); // wrong

int main() {}
