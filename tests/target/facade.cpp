// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of a drive on a `line`, used as in a program: init, enable, both wheels at a speed, disable.
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "drive.hpp"

namespace {

using namespace servobus;
using wire = line<uart>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
zlac8015d::drive robot{line_1, 1, unsupervised};

} // namespace

extern "C" bool job() {
    using namespace zlac8015d;
    using units::r_per_min;
    return robot.run(init{}) && robot.run(enable_in{operating_mode::velocity}) &&
           robot.run(velocity{30 * r_per_min, 30 * r_per_min}) && robot.run(disable{}) &&
           simulated_drive::has_run();
}
