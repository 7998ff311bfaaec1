// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated drives on one virtual line, with a bus that reads them, and their catalogues; the judges on a drive of
// one's own, advice about faults, why a command was refused, and what all drives share. This file is only compiled.
#include <servobus/bus/bus.hpp>
#include <servobus/control/command_text.hpp>
#include <servobus/control/motor_drive.hpp>
#include <servobus/control/why.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/c630s/arguments.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/yako/advice.hpp>
#include <servobus/device/yako/arguments.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/advice.hpp>
#include <servobus/device/zlac8015d/arguments.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/line/line.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/conformance.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "../../examples/own_device/own_subject.hpp"

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
    scheduled_line on{wire, polls.timing()};
    bus<polls, decltype(on)> all{on};
    all.run_for(time);
    return all.count(0) + all.count(1) + all.count(2);
}

std::size_t registers_with_names() {
    return zlac8015d::catalogue.entries.size() + yako::closed_loop::catalogue.entries.size() +
           yako::open_loop::catalogue.entries.size() + c630s::catalogue.entries.size();
}

void count_findings(void* count, const sim::finding& f) {
    *static_cast<unsigned*>(count) += f.first.request + 1 + static_cast<unsigned>(f.trace.size());
}
unsigned judge() {
    unsigned count = 0;
    sim::conformance<winch::subject> kit{&count_findings, &count};
    const sim::played all = kit.singles();
    (void)kit.pairs(1, 2);
    if (kit.count_pairs(0, {0, 100}) < 1000) (void)kit.every_pair(0, {0, 100});
    (void)kit.from(hex("00 00 01 02 03 04"));
    return all.runs + count;
}
template <motor_drive Drive> bool stops(Drive& drive) {
    return static_cast<bool>(drive.run(disable{})) || Drive::traits.stops_without_line;
}
bool stop(winch::drive<scheduled_line<sim::virtual_line>>& drum) { return stops(drum); }
const char* remedy(zlac8015d::faults f) { return zlac8015d::advice_for(f).remedy; }
const char* remedy(std::uint16_t code) { return c630s::advice_for(code).remedy; }
const char* reset(yako::motion_status s) { return yako::advice_for(s).reset; }
template <class Command, class Drive> bool is_explained(const Drive& drive, const Command& wanted) {
    const refusal r = why(drive, wanted);
    return r.is_of_value() || (r.is_of_state() && (!r.states.is_empty() || r.unmet() != nullptr));
}
bool explain(const winch::drive<scheduled_line<sim::virtual_line>>& drum,
             const zlac8015d::drive<scheduled_line<sim::virtual_line>>& wheels) {
    return is_explained(drum, winch::turn{}) && is_explained(wheels, zlac8015d::wheel_velocities{});
}
bool explain(const yako::open_loop::drive<scheduled_line<sim::virtual_line>>& axis,
             const c630s::drive<scheduled_line<sim::virtual_line>>& servo) {
    return is_explained(axis, yako::open_loop::home{yako::homing::home_24}) &&
           is_explained(servo, c630s::set<c630s::di1_function>{checked(c630s::input_function::none)});
}
const char* what_failed(const zlac8015d::wheel_velocities&, const command_status& r) {
    return r.has_register() && r.register_address() == 0x2088 ? command_text<zlac8015d::wheel_velocities>
                                                              : text(step::kind::confirm);
}
