// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus with the facade of a drive: two cyclic reads, and between them the drive is initialised, enabled,
// moved until the bus has read its speed, and disabled.
#include <servobus/bus/bus.hpp>
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "drive.hpp"

namespace {

using namespace servobus;
using wire = line<uart>;

constexpr node<zlac8015d::device> at{1};
constexpr poll_plan plan{
    modbus::timing_at(115200), controlled_drives{at},
    cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(at, milliseconds(20)),
    cyclic<zlac8015d::status_word>(at, milliseconds(20))};

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
zlac8015d::drive robot{line_1, at, unsupervised};
bus<plan, wire> all{line_1};

bool is_fast() {
    const auto speeds = all.latest<0>(milliseconds(100));
    return speeds && speeds->get<zlac8015d::left_actual_speed>() == 30 * units::r_per_min;
}

} // namespace

extern "C" bool job() {
    using namespace zlac8015d;
    using units::r_per_min;
    if (!all.run(robot, init{}) || !all.run(robot, enable{operating_mode::velocity}) ||
        !all.run(robot, velocity{30 * r_per_min, 30 * r_per_min}))
        return false;
    for (int i = 0; i < 1000 && !is_fast(); ++i) (void)all.step(robot);
    return is_fast() && all.run(robot, disable{}) && simulated_drive::has_run();
}
