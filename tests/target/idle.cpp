// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A step of a facade that has nothing to send, in a function of its own: the wheels turn, their feedback is not due,
// and the command timeout is watched.
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "drive.hpp"

namespace {

using namespace servobus;
using wire = line<uart>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
zlac8015d::drive robot{
    line_1, 1, {.feedback = milliseconds(10'000), .command_timeout = milliseconds(60'000)}};

} // namespace

extern "C" {

[[gnu::noipa]] bool measured_idle_step() { return robot.step() == milliseconds(1); }

bool job() {
    using namespace zlac8015d;
    using units::r_per_min;
    if (!robot.run(init{}) || !robot.run(enable_in{operating_mode::velocity}) ||
        !robot.run(velocity{30 * r_per_min, 30 * r_per_min}))
        return false;
    const std::uint32_t answered = simulated_drive::answered();
    return measured_idle_step() && simulated_drive::answered() == answered && robot.run(disable{});
}
}
