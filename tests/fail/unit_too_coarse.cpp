// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A unit that is finer or coarser than its numbers can say.
// EXPECT: a_unit_is_at_most_65535_times_finer_or_coarser
// MEND: inline constexpr servobus::unit grain = units::volt / 65000;
#include "program.hpp"

inline constexpr servobus::unit grain = units::volt / 70000; // wrong

int main() {}
