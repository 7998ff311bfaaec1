// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two facades of one drive: what one of them commands, the other does not know of.
// EXPECT: a_drive_has_one_facade
// MEND: controlled_drives{node<zlac::device>{1}, node<other::device>{2}}
#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled_drives{node<zlac::device>{1}, node<other::device>{1}}, // wrong
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))};

int main() { return static_cast<int>(plan.polls[0].node_address); }
