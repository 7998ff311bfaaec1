// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// full.cpp, and the drive's facade beside it: initialised, enabled, two speeds, stopped.
#include <servobus/device/zlac8015d.hpp>

#include "board.hpp"
#include "job.hpp"

namespace {

using namespace servobus;
using wire = line<uart>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
client<wire, zlac8015d::device> drive{line_1, node<zlac8015d::device>{1}};
volatile bool is_to_move = false;

bool moves() {
    using namespace zlac8015d;
    zlac8015d::drive wheels{line_1, 1};
    return wheels.run(init{}) && wheels.run(enable{operating_mode::velocity}) &&
           wheels.run(velocity{30 * units::r_per_min, 30 * units::r_per_min}) && wheels.run(disable{});
}

} // namespace

extern "C" bool job() {
    if (is_to_move && !moves()) return false;
    return read_and_write(drive);
}
