// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A read that keeps a drive alive, so seldom that clocks which differ by a few per cent would miss the time.
// EXPECT: a_drive_of_this_plan_could_miss_its_keep_alive
// FIGURES: 1, 937500, 944940, 0, 1008
// MEND: cyclic<zlac::status_word>(quick_node, milliseconds(900)).keeps_alive(milliseconds(1000))
#include "program.hpp"

using namespace servobus;

constexpr auto quick_node = [] {
    node<zlac::device> n{1};
    n.limits.response = milliseconds(3);
    n.gaps.quarantine = milliseconds(2);
    return n;
}();
inline constexpr poll_plan plan{
    modbus::timing_at(115200, modbus::timing_mode::strict),
    cyclic<zlac::status_word>(quick_node, milliseconds(940)).keeps_alive(milliseconds(1000))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
