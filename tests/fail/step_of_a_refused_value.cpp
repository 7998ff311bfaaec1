// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine's step that writes a value which its register would refuse at run time.
// EXPECT: a_step_has_no_value_that_its_register_refuses
// MEND: inline constexpr servobus::step full =
// servobus::steps::write<zlac::left_target_torque>(servobus::clamped(servobus::raw(99999)));
#include "program.hpp"

inline constexpr servobus::step full =
    servobus::steps::write<zlac::left_target_torque>(servobus::checked(servobus::raw(99999))); // wrong

int main() {}
