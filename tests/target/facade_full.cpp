// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of a drive on a `line` with its supervisors, used as in a machine: two operating modes, speeds, a
// move to its target, three kinds of stops, the feedback, a fault and its reset.
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "drive.hpp"

namespace {

using namespace servobus;
using namespace zlac8015d;
using units::pulse;
using units::r_per_min;
using wire = line<uart>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
zlac8015d::drive robot{line_1, 1, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};

bool drives() {
    if (!robot.run(enable_in{operating_mode::velocity}) ||
        !robot.run(velocity{30 * r_per_min, 30 * r_per_min}))
        return false;
    const result<feedback> seen = robot.read();
    return seen && seen->left_speed == 30 * r_per_min && robot.run(halt{}) &&
           robot.run(velocity{20 * r_per_min, -20 * r_per_min}) && robot.run(quick_stop{});
}

bool moves() {
    return robot.run(enable_in{operating_mode::relative_position}) &&
           robot.run(move_by{4096 * pulse, -4096 * pulse}, wait_reached{milliseconds(5000)}).how ==
               arrival_state::reached;
}

bool recovers() {
    simulated_drive::set_fault(static_cast<std::uint32_t>(fault::overcurrent));
    const result<feedback> seen = robot.read();
    return seen && seen->has_fault() && robot.state() == drive_state::faulted && robot.run(fault_reset{});
}

} // namespace

extern "C" bool job() {
    robot.repeat_stops(milliseconds(100));
    return robot.run(init{}) && drives() && moves() && recovers() && robot.run(disable{}) &&
           simulated_drive::has_run() && simulated_drive::has_done_all(4096, -4096);
}
