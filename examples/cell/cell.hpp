// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A robot's wheels, a lift, a press and a sensor of another maker on one line: the plan says what is sent how often,
// and the compiler checks that it fits.
#pragma once

#include <servobus/any_device.hpp>
#include <servobus/client/settings_on_one_line.hpp>

#include "../lift/lift.hpp"
#include "../press/press.hpp"
#include "../robot/robot.hpp"

/// The sensor, from its manual.
namespace eye {
struct device {
    static constexpr servobus::profile facts{.name = "eye", .baud = 38'400};
};
inline constexpr servobus::input_reg<servobus::u16, device> distance{
    0, {0, 65535}, servobus::units::millimetre, 0};
inline constexpr servobus::discrete_input<device> is_door_open{0};
} // namespace eye

namespace cell {
using namespace servobus;
using namespace servobus::literals;

// Presumes devices that respond within 30 ms, and are never late by more than 70 ms: `servobus doctor` measures them.
inline constexpr auto wheels_node = responds_within(node<zlac8015d::device>{1}, 30_ms);
inline constexpr auto lift_node = responds_within(node<yako::closed_loop::device>{2}, 30_ms);
inline constexpr auto press_node = responds_within(node<c630s::device>{3}, 30_ms);
inline constexpr auto eye_node = responds_within(node<eye::device>{9}, 30_ms);
inline constexpr auto shared =
    settings_on_one_line(wheels_node, lift_node, press_node); // 38400 8N1; what each needs to get there
inline constexpr poll_plan plan{
    modbus::timing_at(shared.baud),
    controlled(wheels_node, {.feedback = 50_ms, .command_timeout = 500_ms})
        .commands(50_ms)
        .keeps_alive(1500_ms),
    controlled(lift_node, {.feedback = 100_ms, .command_timeout = no_command_timeout}),
    controlled(press_node, {.feedback = 100_ms, .command_timeout = no_command_timeout}),
    cyclic<eye::distance>(eye_node, 100_ms),
    cyclic<eye::is_door_open>(eye_node, 100_ms)};

inline constexpr take_over wheels_set_up{zlac8015d::resolution{10}, zlac8015d::watchdog{1500_ms}};

template <class Line> struct cell {
    explicit cell(Line& wire)
        : wheels{wire, wheels_node, robot::base, by_plan}, lift{wire, lift_node, ::lift::screw},
          press{wire, press_node, ::press::ram}, all{wire, wheels, lift, press} {
        (void)wheels.set_limits(robot::limits);
    }

    // Waits; lift and press move to their homes, the wheels are enabled.
    bool prepare() {
        auto platform = all.blocking(lift);
        auto ram = all.blocking(press);
        return ::lift::prepare(platform) && all.run(press, ::press::set_up) && ::press::prepare(ram) &&
               all.run(wheels, wheels_set_up) && all.run(wheels, enable{});
    }
    command_status drive(const twist& by) { return is_safe() ? wheels.begin(by) : wheels.begin(halt{}); }
    // The door is closed, nothing is near, and the sensor has said so lately.
    bool is_safe() const {
        const auto ahead = all.template latest<eye::distance>(eye_node, 300_ms);
        const auto door = all.template latest<eye::is_door_open>(eye_node, 300_ms);
        return ahead && door && *ahead > 200_mm && !*door;
    }

    zlac8015d::robot<Line> wheels;
    yako::closed_loop::axis_drive<Line> lift;
    c630s::axis_drive<Line> press;
    bus<plan, Line, decltype(wheels), decltype(lift), decltype(press)> all;
};
} // namespace cell
