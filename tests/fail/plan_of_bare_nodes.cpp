// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plan that names the node of a drive and does not say how its facade is supervised.
// EXPECT: a plan is made of its timing, and of controlled(..), cyclic<..>(..), own_requests(..) and back_off{..}
// MEND: inline constexpr poll_plan plan{modbus::timing_at(9600), controlled(node<zlac::device>{1}, unsupervised),
// cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(9600), node<zlac::device>{1},
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))}; // wrong

int main() {}
