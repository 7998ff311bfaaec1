// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A press on a C630S: segments in millimetres, a limit of the torque, alarms with what to do.
#pragma once

#include <servobus/control/take_over.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/servobus.hpp>

namespace press {
using namespace servobus;
using namespace servobus::literals;
namespace c = servobus::c630s;

inline constexpr auto ram =
    axis::of(lead(5_mm, counts_per_turn{10'000})); // P05-02: reference units of a turn
inline constexpr c::segment_number down{1}, push{2}, up{3};
// A drive that was never set up is switched off and on after the first time, as the status says.
inline constexpr take_over set_up{with_fault_reset{}, c::set_up{}, c::torque_limits{40_percent, 60_percent},
                                  c::position_segments{.type = c::displacement_type::absolute, .last = up},
                                  c::homing_by{c::homing_mode::forward_z, 100_r_per_min, 10_r_per_min}};

template <class Line> using drive = c::axis_drive<Line>; // press::drive<Line> servo{wire, 1, press::ram};

// Waits; the ram moves to its home.
bool prepare(auto& servo) {
    return servo.run(c::axis_segment{down, 75_mm, 50_mm_per_s, 100_ms}) &&
           servo.run(c::axis_segment{push, 100_mm, 5_mm_per_s, 100_ms}) &&
           servo.run(c::axis_segment{up, 0_mm, 50_mm_per_s, 100_ms}) &&
           servo.run(c::enable_in{c::control_mode::position}) && servo.run(c::home{20_s});
}
// True if the ram has reached the end of its stroke, or presses on a piece with all its torque.
bool go(auto& servo, c::segment_number stroke) {
    const axis_arrival there = servo.run(c::start_segment{stroke}, wait_reached{milliseconds(10'000)});
    return there.how == arrival_state::reached || there.cause == stop_cause::blocked;
}
// From a piece the rest of the stroke is given up first: a segment that has begun would go on.
bool raise(auto& servo) {
    const bool is_held = servo.arrival().how == arrival_state::stopped_short;
    if (is_held && !(servo.run(disable{}) && servo.run(c::enable_in{c::control_mode::position})))
        return false;
    return go(servo, up);
}
bool cycle(auto& servo) { return go(servo, down) && go(servo, push) && raise(servo); }

// What the manual says about the drive's alarm.
advice remedy(auto& servo) { return c::advice_for(servo.read().value_or({}).alarm_code); }
} // namespace press
