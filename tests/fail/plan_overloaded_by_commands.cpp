// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan whose line has time for the feedback of its drive, but not for the commands as well.
// EXPECT: the_entries_of_this_plan_do_not_fit_on_the_line
// MEND: controlled(node<zlac::device>{1}, supervised).commands(milliseconds(100))
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

constexpr supervision supervised{.feedback = milliseconds(100), .command_timeout = milliseconds(500)};
inline constexpr poll_plan plan{
    modbus::timing_at(9600),
    controlled(node<zlac::device>{1}, supervised).commands(milliseconds(40))}; // wrong

int main() { return plan.controlled[0].address; }
