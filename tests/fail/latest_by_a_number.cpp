// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A cyclic value by the place of its entry in the plan.
// EXPECT: a cyclic value is asked for by its row and node: latest<row>(node, oldest)
// MEND: const auto seen = all.latest<other::speed>(left_fan, milliseconds(500));
#include "program.hpp"

using namespace servobus;

constexpr node<other::device> left_fan{1}, right_fan{2};
inline constexpr poll_plan plan{modbus::timing_at(115200), cyclic<other::speed>(left_fan, milliseconds(200)),
                                cyclic<other::next_speed>(right_fan, milliseconds(200))};

int main() {
    some_port port;
    scheduled_line wire{port, plan.timing()};
    auto all = make_bus<plan>(wire);
    const auto seen = all.latest<0>(milliseconds(500)); // wrong
    return seen ? 0 : 1;
}
