// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan that leaves the supervision of a drive to the plan.
// EXPECT: a_plan_states_the_supervision_itself
// MEND: controlled(node<zlac::device>{1}, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)})
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, by_plan)}; // wrong

int main() { return plan.controlled[0].address; }
