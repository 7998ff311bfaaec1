// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that writes a code which the register does not have.
// EXPECT: this_constant_is_outside_the_range_of_the_register
// MEND: inline constexpr servobus::step mode =
// servobus::steps::write<zlac::mode_of_operation>(zlac::operating_mode{3});
#include "program.hpp"

inline constexpr servobus::step mode =
    servobus::steps::write<zlac::mode_of_operation>(zlac::operating_mode{9}); // wrong

int main() {}
