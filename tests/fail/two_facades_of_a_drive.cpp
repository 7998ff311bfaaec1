// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two facades of one drive: what one of them commands, the other does not know of.
// EXPECT: a_drive_has_one_facade
// MEND: controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}), controlled(node<zlac::device>{2}, unsupervised)
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{
    modbus::timing_at(115200), controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
    controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)})}; // wrong

int main() { return plan.controlled[0].address; }
