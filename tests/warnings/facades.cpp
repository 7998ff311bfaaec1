// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facades of all drives on a serial port: commands, moves until arrival, feedback, steps, terminals; a robot by
// twists, axes by lengths. This file is only compiled.
#include <servobus/servobus.hpp>

#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/device/c630s/wiring.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/device/yako/wiring.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/device/zlac8015d/wiring.hpp>
#include <servobus/explain/explain.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/registers/format.hpp>
#include <servobus/registers/literals.hpp>
#include <servobus/words.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::literals;

using wire = line<posix::serial>;

bool turns(zlac8015d::drive<wire>& wheels) {
    using namespace zlac8015d;
    return wheels.run(init{}) && wheels.run(enable{}) && wheels.run(velocity{30_r_per_min, -30_r_per_min}) &&
           wheels.run(disable{}) && wheels.feedback(milliseconds(100));
}
bool moves(yako::closed_loop::drive<wire>& lift) {
    using namespace yako;
    return lift.run(init{}) && lift.run(enable{}) && lift.run(disable{}) && lift.feedback(milliseconds(100));
}
bool moves(yako::open_loop::drive<wire>& lift) {
    using namespace yako;
    return lift.run(init{}) && lift.run(enable{}) && lift.run(disable{}) && lift.feedback(milliseconds(100));
}
bool moves(c630s::drive<wire>& spindle) {
    using namespace c630s;
    return spindle.run(init{}) && spindle.run(enable{}) && spindle.run(disable{}) &&
           spindle.feedback(milliseconds(100));
}
bool is_taken_over(zlac8015d::drive<wire>& wheels, c630s::drive<wire>& spindle) {
    using namespace zlac8015d;
    return wheels.run(take_over{with_fault_reset{}, resolution{10}, watchdog{500 * millisecond}}) &&
           spindle.run(take_over{c630s::set_up{}, c630s::torque_limits{40 * percent, 40 * percent}});
}

bool are_wired(zlac8015d::drive<wire>& wheels, yako::closed_loop::drive<wire>& lift,
               c630s::drive<wire>& spindle) {
    return wheels.run(zlac8015d::wire_inputs{.x0 = zlac8015d::input_function::undefined}) &&
           wheels.run(zlac8015d::wire_outputs{.y0 = zlac8015d::output_function::alarm}) &&
           lift.run(yako::wire_inputs{.x0 = yako::input_function::home}) &&
           lift.run(yako::wire_outputs{.y0 = yako::output_function::brake}) &&
           spindle.run(c630s::wire_inputs{.di1 = c630s::input_function::home_switch}) &&
           spindle.run(c630s::wire_outputs{.do1 = c630s::output_function::servo_ready});
}

constexpr auto shared = settings_on_one_line(node<zlac8015d::device>{1}, node<yako::closed_loop::device>{2},
                                             node<c630s::device>{3});
status open(posix::serial& port) { return port.open("/dev/ttyUSB0", posix::settings_of(shared)); }

loop_part loops(zlac8015d::drive<wire>& wheels, yako::closed_loop::drive<wire>& lift) {
    setpoint_loop driven{wheels, take_over{zlac8015d::resolution{10}}, enable{},
                         setpoints<zlac8015d::clamped_velocity>{}};
    driven.enable();
    driven.set({30_r_per_min, -30_r_per_min});
    wheels.line().sleep(driven.step());
    setpoint_loop moved{lift, take_over{disable{}}};
    if (moved.begin(move_by{500 * pulse}) != errc::ok && moved.reset_faults()) (void)moved.halt();
    setpoint_loop homed{lift, take_over{disable{}}, enable{},
                        after_enable{yako::closed_loop::home{yako::homing::home_24}, read_feedback{}}};
    homed.command();
    if (homed.begin(move_by{500 * pulse}) != errc::ok) (void)homed.halt();
    return driven.take_report().what;
}

namespace {
constexpr feed wheel = rolling(534_mm, counts_per_turn{4096});
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 400_mm});
constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr auto ram = axis::of(lead(5_mm, counts_per_turn{10'000}));
constexpr axis_profile quick{.top = 50_mm_per_s, .acceleration = 100_ms, .deceleration = 100_ms};
} // namespace

plane_pose go(wire& on, std::int32_t speed) {
    zlac8015d::robot robot{on, 1, base, {.command_timeout = milliseconds(300)}};
    if (!robot.run(init{}) || !robot.run(enable{})) return robot.pose();
    if (robot.begin(twist{speed * units::micrometre_per_second, 250_mrad_per_s}) != errc::ok)
        robot.set_pose(plane_pose::at(1_m, 0_m, 90_mrad));
    robot.step();
    (void)robot.run(twist{});
    return robot.pose();
}
template <class Lift> micrometres raise(Lift& lift) {
    (void)lift.run(limit_travel{-2_mm, 200_mm});
    if (lift.begin(move_by{-0.4_mm, quick}) == errc::ok) lift.step();
    const axis_arrival a = lift.run(move_to{125.5_mm, quick}, wait_reached{});
    if (a.how != arrival_state::reached) return a.missing;
    if (!lift.run(declare_position{0_mm})) return {};
    return lift.position(milliseconds(100)).value_or({});
}
micrometres raise_closed(wire& on) {
    yako::closed_loop::axis_drive lift{on, 2, screw};
    return raise(lift);
}
micrometres raise_open(wire& on) {
    yako::open_loop::axis_drive lift{on, node<yako::open_loop::device>{3}, screw};
    return raise(lift);
}
micrometres_per_second press(wire& on) {
    c630s::axis_drive servo{on, 4, ram, without_watchdog, c630s::encoder_counts::of_23_bits};
    if (!servo.run(c630s::axis_segment{1, 75_mm, 50_mm_per_s, 100_ms})) return {};
    if (servo.run(c630s::start_segment{1}, wait_reached{}).how == arrival_state::reached)
        (void)servo.run(velocity{10_mm_per_s});
    return servo.geometry().speed_of(servo.geometry().motor_speed_of(1_mm_per_s).value_or({}));
}
micrometres move_belts(wire& on) {
    zlac8015d::axes belts{on, 5, ram, screw, {.command_timeout = 300_ms}};
    if (belts.left().begin(velocity{10_mm_per_s}) != errc::ok) return {};
    if (!belts.right().run(move_to{10_mm})) return belts.right().arrival().missing;
    if (belts.left().speed(milliseconds(100)).value_or({}) > 5_mm_per_s) return {};
    const axis_arrival a = belts.left().run(move_by{10_mm}, wait_reached{});
    return a.how == arrival_state::reached ? belts.left().position(milliseconds(100)).value_or({})
                                           : a.missing;
}
