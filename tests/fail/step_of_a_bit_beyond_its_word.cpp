// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that waits for a bit which its register of 16 bits does not have.
// EXPECT: bits_of_a_step_lie_in_one_word_of_its_register
// MEND: inline constexpr servobus::step awaited = servobus::steps::until_bits<zlac::left_faults>(0x8000, 0, 100);
#include "program.hpp"

inline constexpr servobus::step awaited =
    servobus::steps::until_bits<zlac::left_faults>(0x1'0000, 0, 100); // wrong

int main() {}
