// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program in a machine's units: a robot by twists, a lift and a press by lengths. This file is only compiled.
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/servobus.hpp>

using namespace servobus;
using namespace servobus::literals;

struct some_uart {
    transfer send(bytes);
    bool sent();
    transfer receive(byte_buffer);
    instant now();
};

namespace {
constexpr feed wheel = rolling(534_mm, counts_per_turn{4096});
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr auto ram = axis::of(lead(5_mm, counts_per_turn{10'000}));
constexpr axis_profile quick{.top = 50_mm_per_s, .acceleration = 100_ms, .deceleration = 100_ms};
} // namespace

plane_pose go(line<some_uart>& wire, std::int32_t speed) {
    zlac8015d::robot robot{wire, 1, base, {.command_timeout = milliseconds(300)}};
    if (!robot.run(init{}) || !robot.run(enable{})) return robot.pose();
    if (robot.begin(twist{speed * units::micrometre_per_second, 250_mrad_per_s}) != errc::ok)
        robot.set_pose(plane_pose::at(1_m, 0_m, 90_mrad));
    robot.step();
    (void)robot.run(twist{});
    return robot.pose();
}
template <class Lift> micrometres raise(Lift& lift) {
    (void)lift.run(travel_limits{.lowest = -2_mm, .highest = 200_mm});
    if (lift.begin(travel_by{-0.4_mm, quick}) == errc::ok) lift.step();
    const axis_arrival a = lift.run(travel_to{125.5_mm, quick}, wait_reached{});
    if (a.how != arrival_state::reached) return a.missing;
    if (!lift.run(declare_place{0_mm})) return {};
    return lift.position(milliseconds(100)).value_or({});
}
micrometres raise_closed(line<some_uart>& wire) {
    yako::closed_loop::axis_drive lift{wire, 2, screw};
    return raise(lift);
}
micrometres raise_open(line<some_uart>& wire) {
    yako::open_loop::axis_drive lift{wire, node<yako::open_loop::device>{3}, screw};
    return raise(lift);
}
micrometres_per_second press(line<some_uart>& wire) {
    c630s::axis_drive servo{wire, 4, ram, {}, c630s::encoder_counts::of_23_bits};
    if (!servo.run(c630s::axis_segment{1, 75_mm, 50_mm_per_s, 100_ms})) return {};
    if (servo.run(c630s::start_segment{1}, wait_reached{}).how == arrival_state::reached)
        (void)servo.run(travel_at{10_mm_per_s});
    return servo.geometry().speed_of(servo.geometry().motor_speed_of(1_mm_per_s).value_or({}));
}
micrometres move_belts(line<some_uart>& wire) {
    zlac8015d::axes belts{wire, 5, ram, screw, {.command_timeout = 300_ms}};
    if (belts.left().begin(travel_at{10_mm_per_s}) != errc::ok) return {};
    if (!belts.right().run(travel_to{10_mm})) return belts.right().arrival().missing;
    if (belts.left().speed(milliseconds(100)).value_or({}) > 5_mm_per_s) return {};
    const axis_arrival a = belts.left().run(travel_by{10_mm}, wait_reached{});
    return a.how == arrival_state::reached ? belts.left().position(milliseconds(100)).value_or({})
                                           : a.missing;
}
