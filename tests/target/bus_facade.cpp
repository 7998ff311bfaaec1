// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus with the facade of a drive: it reads the feedback and one register of it, and between them the drive is
// initialised, enabled, moved until its speed was read, and disabled.
#include <servobus/bus/bus.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "drive.hpp"

namespace {

using namespace servobus;
using wire = scheduled_line<uart>;

constexpr node<zlac8015d::device> at{1};
constexpr poll_plan plan{modbus::timing_at(115200),
                         controlled(at, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}),
                         cyclic<zlac8015d::bus_voltage>(at, milliseconds(100))};

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
zlac8015d::drive robot{line_1, at, by_plan};
auto all = make_bus<plan>(line_1, robot);

bool is_fast() {
    const auto seen = robot.feedback(milliseconds(100));
    return seen && seen->left_speed == 30 * units::r_per_min &&
           all.latest<zlac8015d::bus_voltage>(at, milliseconds(200));
}

} // namespace

extern "C" bool job() {
    using namespace zlac8015d;
    using units::r_per_min;
    if (!all.run(robot, init{}) || !all.run(robot, enable_in{operating_mode::velocity}) ||
        !all.run(robot, velocity{30 * r_per_min, 30 * r_per_min}))
        return false;
    for (int i = 0; i < 1000 && !is_fast(); ++i) (void)all.step();
    return is_fast() && all.run(robot, disable{}) && simulated_drive::has_run();
}
