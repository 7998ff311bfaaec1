// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two entries for the program's own requests to a node: which of their limits would count?
// EXPECT: the_requests_to_a_node_are_one_entry
// MEND: own_requests(node<zlac::device>{9}, milliseconds(500), 4)
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
                                own_requests(node<zlac::device>{9}, milliseconds(500), 4),
                                own_requests(node<zlac::device>{9}, milliseconds(100), 1)}; // wrong

int main() { return static_cast<int>(plan.requested); }
