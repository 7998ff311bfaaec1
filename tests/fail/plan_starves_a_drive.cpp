// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives that could keep the line from a third one for longer than its watchdog allows.
// EXPECT: a_drive_of_this_plan_could_miss_its_keep_alive
// MEND: controlled(node<zlac::device>{1}, supervised).keeps_alive(milliseconds(5000))
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

constexpr supervision supervised{.feedback = milliseconds(50), .command_timeout = milliseconds(500)};
inline constexpr poll_plan plan{
    modbus::timing_at(115200), controlled(node<zlac::device>{1}, supervised), // wrong
    controlled(node<zlac::device>{2}, supervised).keeps_alive(milliseconds(5000)),
    controlled(node<zlac::device>{3}, supervised).keeps_alive(milliseconds(5000))};

int main() { return plan.controlled[0].address; }
