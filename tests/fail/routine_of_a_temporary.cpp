// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine of a table that is gone when it runs.
// EXPECT: deleted
// MEND: inline constexpr servobus::routine steps{stops};
#include <array>

#include "program.hpp"

inline constexpr servobus::routine steps{
    std::array{servobus::steps::write_zero<zlac::left_target_position>()}}; // wrong

int main() {}
