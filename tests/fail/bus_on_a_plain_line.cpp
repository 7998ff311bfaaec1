// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus on a line that does not ask it: requests of others would pass by the bus.
// EXPECT: a bus has a scheduled_line, not a line
// MEND: scheduled_line wire{port, plan.timing()};
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200),
                                controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)})};

int main() {
    some_port port;
    line wire{port, plan.timing()}; // wrong
    zlac::drive wheels{wire, 1, by_plan};
    auto all = make_bus<plan>(wire, wheels);
    (void)all.step();
}
