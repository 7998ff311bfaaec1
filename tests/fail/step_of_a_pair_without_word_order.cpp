// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that writes a 32-bit constant to a drive that can switch its word order: a command with arguments
// sends them in the order that was read.
// EXPECT: a_constant_of_two_words_needs_the_word_order_of_the_profile
// MEND: inline constexpr servobus::step go_to = servobus::steps::write_arguments<switched::place>();
#include "program.hpp"
#include "switched.hpp"

inline constexpr servobus::step go_to = servobus::steps::write<switched::place>(1000); // wrong

int main() {}
