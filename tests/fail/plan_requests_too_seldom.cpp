// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests every 40 minutes: the clock wraps after 71, and their share of the line is not worth a period.
// EXPECT: requests_have_a_period_of_half_an_hour_at_most
// MEND: own_requests(node<zlac::device>{8}, milliseconds(1'700'000), 2)
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
                                own_requests(node<zlac::device>{8}, milliseconds(2'400'000), 2)}; // wrong

int main() { return static_cast<int>(plan.requested); }
