// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated drives on one virtual line, with a bus that reads them, and their catalogues. This file is only
// compiled.
#include <servobus/bus/bus.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/line/line.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

using namespace servobus;

constexpr node<zlac8015d::device> wheels{1};
constexpr node<yako::closed_loop::device> lift{2};
constexpr node<c630s::device> spindle{3};
constexpr poll_plan polls{modbus::timing_at(115200),
                          cyclic<zlac8015d::left_actual_speed>(wheels, milliseconds(50)),
                          cyclic<yako::closed_loop::error_code>(lift, milliseconds(100)),
                          cyclic<c630s::servo_status>(spindle, milliseconds(100))};

std::uint64_t read_all(duration time) {
    sim::zlac8015d first;
    sim::yako_closed_loop second;
    sim::c630s third;
    sim::station on_first{first, wheels.address, 115200, microseconds(500)};
    sim::station on_second{second, lift.address, 115200, microseconds(500)};
    sim::station on_third{third, spindle.address, 115200, microseconds(500)};
    sim::virtual_line wire{115200};
    wire.attach(on_first);
    wire.attach(on_second);
    wire.attach(on_third);
    line on{wire, polls.timing()};
    bus<polls, decltype(on)> all{on};
    all.run_for(time);
    return all.count(0) + all.count(1) + all.count(2);
}

std::size_t registers_with_names() {
    return zlac8015d::catalogue.entries.size() + yako::closed_loop::catalogue.entries.size() +
           yako::open_loop::catalogue.entries.size() + c630s::catalogue.entries.size();
}
