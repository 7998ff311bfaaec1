// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read every 40 minutes: the clock wraps after 71, and what is due could not be told from what was.
// EXPECT: a_cyclic_read_has_a_period_of_half_an_hour_at_most
// MEND: cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(1'700'000))
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(2'400'000))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
