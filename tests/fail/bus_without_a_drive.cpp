// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus that leaves out a drive of its plan, which would not be stepped.
// EXPECT: a bus has the controlled drives of its plan, in their order, and no others
// MEND: auto all = make_bus<plan>(wire, wheels);
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)})};

int main() {
    some_port port;
    scheduled_line wire{port, plan.timing()};
    zlac::drive wheels{wire, 1, by_plan};
    auto all = make_bus<plan>(wire); // wrong
    (void)wheels;
    (void)all.step();
}
