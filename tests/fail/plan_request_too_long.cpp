// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// No request carries so many registers.
// EXPECT: a_request_has_1_to_125_registers
// MEND: own_requests(node<zlac::device>{9}, milliseconds(500), 125)
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
                                own_requests(node<zlac::device>{9}, milliseconds(500), 126)}; // wrong

int main() { return static_cast<int>(plan.requested); }
