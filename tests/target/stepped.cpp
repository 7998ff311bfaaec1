// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The job of `full`, by stepped calls: the program's main loop never waits.
#include "board.hpp"

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

namespace {

using namespace servobus;
using namespace servobus::zlac8015d;
using wire = line<uart, counters, unechoed>;

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
client<wire, device> drive{line_1, node<device>{1}};

} // namespace

extern "C" bool job() {
    stepped_read<decltype(drive), left_faults, right_faults, left_actual_position, right_actual_position,
                 left_actual_speed, right_actual_speed>
        state{drive};
    if (state.begin() != errc::ok) return false;
    while (!state.done()) state.step();
    const auto now = state.value();
    if (!now || !(now->get<left_actual_position>() < now->get<right_actual_position>())) return false;
    stepped_write<decltype(drive), left_target_speed, right_target_speed> speeds{drive};
    if (speeds.begin(raw(60), raw(50)) != errc::ok) return false;
    while (!speeds.done()) speeds.step();
    return speeds.status() == errc::ok;
}
