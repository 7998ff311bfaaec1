// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels and a lift on one line in virtual time, and a plan for their facades. The frames of its reads differ from
// those of the facades.
#pragma once

#include <servobus/bus/bus.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/loop_bound.hpp>

namespace tests {

// These drives respond within a few milliseconds, so their time limits are short, and an absent drive costs little.
inline constexpr auto wheels_node =
    servobus::responds_within(servobus::node<servobus::zlac8015d::device>{1}, servobus::milliseconds(30));
inline constexpr auto lift_node = servobus::responds_within(
    servobus::node<servobus::yako::closed_loop::device>{2}, servobus::milliseconds(30));

inline constexpr servobus::poll_plan fast_plan{
    servobus::modbus::timing_at(115200),
    servobus::controlled(wheels_node, {.feedback = servobus::milliseconds(20),
                                       .command_timeout = servobus::no_command_timeout}),
    servobus::controlled(
        lift_node, {.feedback = servobus::milliseconds(30), .command_timeout = servobus::no_command_timeout}),
    servobus::cyclic<servobus::zlac8015d::bus_voltage>(wheels_node, servobus::milliseconds(50)),
    servobus::cyclic<servobus::yako::closed_loop::output_polarity>(lift_node, servobus::milliseconds(60)),
    servobus::cyclic<servobus::yako::actual_position>(lift_node, servobus::milliseconds(100))};

struct wheels_and_lift {
    servobus::sim::zlac8015d wheels_model;
    servobus::sim::yako_closed_loop lift_model{servobus::sim::yako_options{.switches = 2}};
    servobus::sim::station<servobus::sim::zlac8015d> wheels_station{wheels_model};
    servobus::sim::station<servobus::sim::yako_closed_loop> lift_station{lift_model};
    servobus::sim::virtual_line wire{115200};

    explicit wheels_and_lift(servobus::sim::zlac8015d_options wheels_interpretations = {})
        : wheels_model{wheels_interpretations} {
        wire.attach(wheels_station);
        wire.attach(lift_station);
    }
    wheels_and_lift(const wheels_and_lift&) = delete;
    wheels_and_lift& operator=(const wheels_and_lift&) = delete;
};

/// The program that controls the drives. Another one in its place is the program after a restart.
struct wheels_and_lift_program {
    using line_type = servobus::scheduled_line<servobus::sim::virtual_line>;

    line_type on;
    servobus::zlac8015d::drive<line_type> wheels{on, wheels_node, servobus::by_plan};
    servobus::yako::closed_loop::drive<line_type> lift{on, lift_node};
    servobus::bus<fast_plan, line_type, decltype(wheels), decltype(lift)> all{on, wheels, lift};

    explicit wheels_and_lift_program(servobus::sim::virtual_line& wire)
        : on{wire, servobus::modbus::timing_at(115200)} {}

    void turn() {
        const servobus::duration idle = all.step();
        on.port().wait(idle.us == 0 ? servobus::microseconds(1) : idle);
    }
    void run(std::uint32_t ms) {
        const std::uint64_t end = on.port().time_us() + std::uint64_t{ms} * 1000u;
        while (on.port().time_us() < end) turn();
    }
    template <class Drive, class Wanted>
    servobus::command_status command(Drive& drive, const Wanted& wanted) {
        if (const servobus::command_status begun = drive.begin(wanted); !begun) return begun;
        for (tests::loop_bound left{"the end of a command"}; !drive.is_idle(); left.use()) turn();
        return drive.last();
    }
};

} // namespace tests
