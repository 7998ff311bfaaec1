// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A lift on a YAKO with closed loop: homing by a switch, moves in millimetres, jogging while a button is held, a stop
// input.
#pragma once

#include <servobus/control/take_over.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/servobus.hpp>

namespace lift {
using namespace servobus;
using namespace servobus::literals;
namespace y = servobus::yako;

inline constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000})); // 0011h: pulses of a turn
inline constexpr axis_profile fast{.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms};
// The inputs are set without power.
inline constexpr take_over set_up{with_fault_reset{},
                                  disable{},
                                  y::set_input{y::input_terminal::x0, y::input_function::home},
                                  y::set_input{y::input_terminal::x1, y::input_function::positive_limit},
                                  y::set_input{y::input_terminal::x2, y::input_function::negative_limit},
                                  y::set_input{y::input_terminal::x3, y::input_function::stop},
                                  y::set_over_travel_stop{y::over_travel_stop::emergency_stop},
                                  y::set_homing_profile{120_r_per_min, 30_r_per_min, 100_ms}};

template <class Line>
using drive = y::closed_loop::axis_drive<Line>; // lift::drive<Line> platform{wire, 1, lift::screw};

// After each loss too. Waits; the platform moves to its home switch.
bool prepare(auto& platform) {
    return platform.run(set_up) && platform.run(enable{}) &&
           platform.run(y::closed_loop::home{y::homing::home_24}) &&
           platform.run(limit_travel{-2_mm, 200_mm});
}
axis_arrival go_to(auto& platform, micrometres place) {
    return platform.run(move_to{place, fast}, wait_reached{});
}
// In each iteration of a loop: up, down, or 0 while no button is held. `held` is the loop's own, 0 at first.
duration jog(auto& platform, micrometres_per_second speed, micrometres_per_second& held) {
    const duration idle = platform.step();
    if (!platform.is_idle()) return idle;
    if (speed == held && speed.count() != 0) (void)platform.begin(hold{speed, milliseconds(50)});
    if (speed != held && platform.begin(halt{}) == errc::ok) held = speed; // also to turn round
    return idle;
}
} // namespace lift
