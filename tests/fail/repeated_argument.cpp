// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A step that may be repeated although it writes what the caller gives.
// EXPECT: a_repeatable_step_writes_a_constant
// MEND: inline constexpr servobus::step stop =
// servobus::steps::repeatable(servobus::steps::write<zlac::control_word>(zlac::control_code::stop));
#include "program.hpp"

inline constexpr servobus::step stop =
    servobus::steps::repeatable(servobus::steps::write_arguments<zlac::control_word>()); // wrong

int main() {}
