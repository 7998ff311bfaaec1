// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive whose watchdog could strike while others do not answer.
// EXPECT: a_drive_of_this_plan_could_miss_its_keep_alive
// MEND: cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50)).keeps_alive(milliseconds(1000))
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))
                                    .keeps_alive(milliseconds(200))}; // wrong

int main() { return static_cast<int>(plan.polls[0].node_address); }
