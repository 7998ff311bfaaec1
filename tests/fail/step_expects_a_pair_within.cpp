// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that requires a 32-bit register to be near zero: it compares signed words.
// EXPECT: a_step_compares_16_bits_of_registers_of_one_word
// MEND: inline constexpr servobus::step is_slow = servobus::steps::expect_within<zlac::left_actual_speed>(20,
// servobus::errc::busy);
#include "program.hpp"

inline constexpr servobus::step is_slow =
    servobus::steps::expect_within<zlac::left_actual_position>(20, servobus::errc::busy); // wrong

int main() {}
