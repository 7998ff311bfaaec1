// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan that polls a drive and does not say what stops it when the program no longer commands.
// EXPECT: this drive needs a command timeout, or no_command_timeout by name
// MEND: controlled(node<zlac::device>{1}, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)})
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.feedback = milliseconds(20)})}; // wrong

int main() { return plan.controlled[0].address; }
