// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus that has a servo where its plan has wheels.
// EXPECT: a bus has the controlled drives of its plan, in their order, and no others
// MEND: auto all = make_bus<plan>(wire, wheels);
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)})};

int main() {
    some_port port;
    scheduled_line wire{port, plan.timing()};
    c630s::drive servo{wire, 1};
    auto all = make_bus<plan>(wire, servo); // wrong
    (void)all.step();
}
