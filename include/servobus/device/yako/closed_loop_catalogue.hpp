// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, closed loop: the registers with their names. Tools and tests include it; programs
// on a target do not. Source: the rows of yako/common.hpp and yako/closed_loop.hpp.
//
//     constexpr const entry* e = yako::closed_loop::catalogue.find(0x000C);
//     static_assert(e->rights == access::ro && e->kind == value_kind::signed_word); // actual_speed
//     static_assert(has(e->flags, flag::scaled_elsewhere));                         // by 001Ah
#pragma once

#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/closed_loop_descriptions.hpp>
#include <servobus/device/yako/names.hpp>

namespace servobus::yako::closed_loop {

namespace names {
using namespace yako::names;

// clang-format off
inline constexpr named_value inputs_names[] = {
    named_bit(1, "x0"), named_bit(2, "x1"), named_bit(4, "x2"), named_bit(8, "x3"),
};
inline constexpr named_value outputs_names[] = {
    named_bit(1, "y0"), named_bit(2, "y1"),
};
inline constexpr named_value speed_count_names[] = {
    code(0, "1 r/min"), code(1, "0.1 r/min"),
};
inline constexpr named_value homing_names[] = {
    code(0xFFFF, "mechanical stop 1"), code(0xFFFE, "mechanical stop 2"), code(0xFFFD, "mechanical stop 3"),
    code(0xFFFC, "mechanical stop 4"),
    code(1, "negative limit and index"), code(2, "positive limit and index"),
    code(3, "positive home and index 3"), code(4, "positive home and index 4"),
    code(5, "negative home and index 5"), code(6, "negative home and index 6"),
    code(7, "home and index 7"), code(8, "home and index 8"), code(9, "home and index 9"),
    code(10, "home and index 10"), code(11, "home and index 11"), code(12, "home and index 12"),
    code(13, "home and index 13"), code(14, "home and index 14"),
    code(17, "negative limit"), code(18, "positive limit"), code(19, "positive home 19"), code(20, "positive home 20"),
    code(21, "negative home 21"), code(22, "negative home 22"), code(23, "home 23"), code(24, "home 24"),
    code(25, "home 25"), code(26, "home 26"), code(27, "home 27"), code(28, "home 28"), code(29, "home 29"),
    code(30, "home 30"), code(33, "index negative"), code(34, "index positive"),
    code(35, "current position"),
};
inline constexpr named_value control_algorithm_names[] = {
    code(1, "open loop"), code(2, "switching"), code(3, "closed loop"),
};

inline constexpr auto entries = in_address_order(
    family,
    list("input_state", closed_loop::input_state, naming::names, inputs_names),
    list("output_state", closed_loop::output_state, naming::names, outputs_names),
    list("actual_speed", closed_loop::actual_speed),
    list("speed_resolution", closed_loop::speed_resolution, naming::names, speed_count_names),
    list("jog_speed", closed_loop::jog_speed),
    list("start_speed", closed_loop::start_speed),
    list("positioning_speed", closed_loop::positioning_speed),
    list("homing_method", closed_loop::homing_method, naming::names, homing_names),
    list("homing_fast_speed", closed_loop::homing_fast_speed),
    list("homing_slow_speed", closed_loop::homing_slow_speed),
    list("collision_threshold", closed_loop::collision_threshold),
    list("collision_current", closed_loop::collision_current),
    list("input_polarity", closed_loop::input_polarity, naming::names, inputs_names),
    list("output_polarity", closed_loop::output_polarity, naming::names, outputs_names),
    list("user_outputs", closed_loop::user_outputs, naming::names, outputs_names),
    list("position_segment_", closed_loop::position_segment_speeds, "_speed"),
    list("position_segment_", closed_loop::position_segment_acceleration_times, "_acceleration_time"),
    list("position_segment_", closed_loop::position_segment_deceleration_times, "_deceleration_time"),
    list("speed_segment_", closed_loop::speed_segment_speeds, "_speed"),
    list("speed_segment_", closed_loop::speed_segment_acceleration_times, "_acceleration_time"),
    list("speed_segment_", closed_loop::speed_segment_deceleration_times, "_deceleration_time"),
    list("closed_loop_algorithm", closed_loop::closed_loop_algorithm, naming::names, control_algorithm_names),
    list("encoder_resolution", closed_loop::encoder_resolution),
    list("max_current", closed_loop::max_current),
    list("closed_loop_max_current", closed_loop::closed_loop_max_current),
    list("holding_current", closed_loop::holding_current),
    list("holding_delay", closed_loop::holding_delay),
    list("following_error_limit", closed_loop::following_error_limit),
    list("position_window", closed_loop::position_window),
    list("la_speed_kp_1", closed_loop::la_speed_kp_1),
    list("la_speed_kv_1", closed_loop::la_speed_kv_1),
    list("la_speed_node_1", closed_loop::la_speed_node_1),
    list("la_speed_kp_2", closed_loop::la_speed_kp_2),
    list("la_speed_kv_2", closed_loop::la_speed_kv_2),
    list("la_speed_node_2", closed_loop::la_speed_node_2),
    list("la_speed_feedforward_kvf", closed_loop::la_speed_feedforward_kvf),
    list("la_position_ki", closed_loop::la_position_ki));
// clang-format on
} // namespace names

static_assert(is_in_order(names::entries));
static_assert(is_described(names::entries, descriptions));

/// All 204 registers, at 225 addresses.
inline constexpr servobus::catalogue catalogue{&device::facts, names::entries, descriptions};

} // namespace servobus::yako::closed_loop
