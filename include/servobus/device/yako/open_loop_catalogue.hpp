// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers, open loop: the registers with their names. Tools and tests include it; programs on
// a target do not. Source: the rows of yako/common.hpp and yako/open_loop.hpp.
//
//     constexpr const entry* e = yako::open_loop::catalogue.find(0x0025); // the second word of 0024h
//     static_assert(e->address == 0x0024 && e->words() == 2);             // target_position
#pragma once

#include <servobus/device/yako/names.hpp>
#include <servobus/device/yako/open_loop.hpp>
#include <servobus/device/yako/open_loop_descriptions.hpp>

namespace servobus::yako::open_loop {

namespace names {
using namespace yako::names;

// clang-format off
inline constexpr named_value inputs_names[] = {
    named_bit(1, "x0"), named_bit(2, "x1"), named_bit(4, "x2"), named_bit(8, "x3"), named_bit(16, "x4"), named_bit(32, "x5"), named_bit(64, "x6"),
};
inline constexpr named_value outputs_names[] = {
    named_bit(1, "y0"), named_bit(2, "y1"), named_bit(4, "y2"),
};
inline constexpr named_value homing_names[] = {
    code(17, "negative limit"), code(18, "positive limit"), code(19, "positive home 19"), code(20, "positive home 20"),
    code(21, "negative home 21"), code(22, "negative home 22"), code(23, "home 23"), code(24, "home 24"),
    code(25, "home 25"), code(26, "home 26"), code(27, "home 27"), code(28, "home 28"), code(29, "home 29"),
    code(30, "home 30"), code(35, "current position"),
};

inline constexpr auto entries = in_address_order(
    family,
    list("input_state", open_loop::input_state, naming::names, inputs_names),
    list("output_state", open_loop::output_state, naming::names, outputs_names),
    list("actual_speed", open_loop::actual_speed),
    list("jog_speed", open_loop::jog_speed),
    list("start_speed", open_loop::start_speed),
    list("positioning_speed", open_loop::positioning_speed),
    list("homing_method", open_loop::homing_method, naming::names, homing_names),
    list("homing_fast_speed", open_loop::homing_fast_speed),
    list("homing_slow_speed", open_loop::homing_slow_speed),
    list("input_polarity", open_loop::input_polarity, naming::names, inputs_names),
    list("x4_function", open_loop::x4_function, naming::names, input_function_names),
    list("x5_function", open_loop::x5_function, naming::names, input_function_names),
    list("x6_function", open_loop::x6_function, naming::names, input_function_names),
    list("output_polarity", open_loop::output_polarity, naming::names, outputs_names),
    list("y2_function", open_loop::y2_function, naming::names, output_function_names),
    list("user_outputs", open_loop::user_outputs, naming::names, outputs_names),
    list("position_segment_", open_loop::position_segment_speeds, "_speed"),
    list("position_segment_", open_loop::position_segment_acceleration_times, "_acceleration_time"),
    list("position_segment_", open_loop::position_segment_deceleration_times, "_deceleration_time"),
    list("speed_segment_", open_loop::speed_segment_speeds, "_speed"),
    list("speed_segment_", open_loop::speed_segment_acceleration_times, "_acceleration_time"),
    list("speed_segment_", open_loop::speed_segment_deceleration_times, "_deceleration_time"),
    list("segment_", open_loop::segment_start_speeds, "_start_speed"),
    list("max_current", open_loop::max_current),
    list("holding_current", open_loop::holding_current),
    list("holding_delay", open_loop::holding_delay));
// clang-format on
} // namespace names

static_assert(is_in_order(names::entries));
static_assert(is_described(names::entries, descriptions));

/// All 208 registers, at 229 addresses.
inline constexpr servobus::catalogue catalogue{&device::facts, names::entries, descriptions};

} // namespace servobus::yako::open_loop
