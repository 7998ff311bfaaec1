// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan that names a node where it takes its drives with a facade.
// EXPECT: a plan is made of its timing, of controlled_drives{...}
// MEND: inline constexpr poll_plan plan{modbus::timing_at(9600),
// controlled_drives{node<zlac::device>{1}}, cyclic<zlac::status_word>(node<zlac::device>{1},
// milliseconds(50))};
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(9600), node<zlac::device>{1},
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))}; // wrong

int main() {}
