// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A turn of a bus that leaves out a facade: its drive would be read without the stop that must go first.
// EXPECT: all controlled_drives of the plan are stepped here, and no others
// MEND: (void)all.step(wheels);
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

inline constexpr poll_plan plan{modbus::timing_at(115200), controlled_drives{node<zlac::device>{1}},
                                cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))};

int main() {
    some_port port;
    line wire{port, plan.timing()};
    zlac::drive wheels{wire, 1, unsupervised};
    bus<plan, line<some_port>> all{wire};
    (void)all.step(); // wrong
    (void)wheels;
}
