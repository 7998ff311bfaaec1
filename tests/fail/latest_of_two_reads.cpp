// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Values of two reads together, which are not of one moment.
// EXPECT: no_cyclic_read_of_the_plan_has_all_these_rows_of_this_node
// MEND: const auto seen = all.latest<zlac::left_actual_speed, zlac::right_actual_speed>(wheels, milliseconds(100));
#include "program.hpp"

using namespace servobus;

constexpr node<zlac::device> wheels{1};
inline constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac::left_actual_speed, zlac::right_actual_speed>(wheels, milliseconds(50)),
    cyclic<zlac::status_word>(wheels, milliseconds(50))};

int main() {
    some_port port;
    scheduled_line wire{port, plan.timing()};
    auto all = make_bus<plan>(wire);
    const auto seen =
        all.latest<zlac::left_actual_speed, zlac::status_word>(wheels, milliseconds(100)); // wrong
    return seen ? 0 : 1;
}
