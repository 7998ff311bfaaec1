// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive of which only the registers are known, but not how it is controlled.
// EXPECT: a controlled drive needs its header, such as servobus/device/zlac8015d.hpp
// MEND: inline constexpr poll_plan plan{modbus::timing_at(115200), cyclic<other::speed>(node<other::device>{1},
// milliseconds(50))};
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    controlled(node<other::device>{1}, {.command_timeout = milliseconds(300)})}; // wrong

int main() { return plan.controlled[0].address; }
