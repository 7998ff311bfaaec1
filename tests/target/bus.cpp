// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// full.cpp, and a bus beside it: two cyclic reads of a node, and what they gave last.
#include <servobus/bus.hpp>

#include "board.hpp"
#include "job.hpp"

namespace {

using namespace servobus;
using wire = line<uart>;

constexpr node<zlac8015d::device> wheels{1};
constexpr poll_plan plan{
    modbus::timing_at(115200), drives_with_a_facade{},
    cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels, milliseconds(20)),
    cyclic<zlac8015d::status_word>(wheels, milliseconds(50))};

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
client<wire, zlac8015d::device> drive{line_1, wheels};
bus<plan, wire> all{line_1};
volatile bool is_to_poll = false;

bool polls() {
    (void)all.step();
    const auto speeds = all.latest<0>(milliseconds(100));
    const auto status = all.latest<1>(milliseconds(100));
    return speeds && status && status->get<zlac8015d::status_word>().to_word() == 0 &&
           speeds->get<zlac8015d::left_actual_speed>() > 3 * units::r_per_min;
}

} // namespace

extern "C" bool job() {
    if (is_to_poll && !polls()) return false;
    return read_and_write(drive);
}
