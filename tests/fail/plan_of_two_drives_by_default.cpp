// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two drives with the default limits of their nodes: a lost response and a stop take longer than a watchdog allows.
// EXPECT: a_drive_of_this_plan_could_miss_its_keep_alive
// FIGURES: 1, 938000, 1105222, 53, 1179
// MEND: consteval node<zlac::device> quick(std::uint8_t address) {
//     return responds_within(node<zlac::device>{address}, milliseconds(53));
// }
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(300)};
constexpr node<zlac::device> left{1}, right{2};
inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(left, supervised),
                                controlled(right, supervised),
                                cyclic<zlac::bus_voltage>(left, milliseconds(200)),
                                cyclic<zlac::bus_voltage>(right, milliseconds(200)),
                                cyclic<zlac::status_word>(left, milliseconds(100))}; // wrong

int main() { return plan.controlled[0].address; }
