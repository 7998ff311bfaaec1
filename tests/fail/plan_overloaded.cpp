// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads that the line has no time for.
// EXPECT: the_entries_of_this_plan_do_not_fit_on_the_line
// FIGURES: 5043, 1, 5043
// MEND: cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(9600),
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(5))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
