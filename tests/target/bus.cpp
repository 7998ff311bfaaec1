// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus on a `line`: two cyclic reads of a node, each made at least once, and a check of their values.
#include <servobus/bus/bus.hpp>
#include <servobus/device/zlac8015d/registers.hpp>

#include "board.hpp"

namespace {

using namespace servobus;
using wire = scheduled_line<uart>;

constexpr node<zlac8015d::device> wheels{1};
constexpr poll_plan plan{
    modbus::timing_at(115200),
    cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels, milliseconds(20)),
    cyclic<zlac8015d::status_word>(wheels, milliseconds(20))};

uart port_1;
wire line_1{port_1, modbus::timing_at(115200)};
bus<plan, wire> all{line_1};

} // namespace

extern "C" bool job() {
    const std::uint32_t speeds_before = all.count(0), states_before = all.count(1);
    for (int i = 0; i < 1000 && (all.count(0) == speeds_before || all.count(1) == states_before); ++i)
        (void)all.step();
    const auto speeds =
        all.latest<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels, milliseconds(100));
    const auto state = all.latest<zlac8015d::status_word>(wheels, milliseconds(100));
    return all.count(0) != speeds_before && all.count(1) != states_before && speeds && state &&
           state->to_word() == 0 && speeds->get<zlac8015d::left_actual_speed>() == 0 * units::r_per_min;
}
