// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads that may have to wait for each other longer than the clock can tell.
// EXPECT: the_times_of_this_plan_are_longer_than_its_clock_can_tell
// MEND: cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(1'000'000))
#include "program.hpp"

using namespace servobus;

constexpr auto slow_node = [] {
    node<zlac::device> n{2};
    n.limits.response = milliseconds(300'000);
    return n;
}();
inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(1'600'000)), // wrong
    cyclic<zlac::status_word>(slow_node, milliseconds(1000))};

int main() { return static_cast<int>(plan.polls[0].node_address); }
