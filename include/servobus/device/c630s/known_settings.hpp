// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Changes the cached settings of a C630S: after an init has read them, a parameter was written, or the servo was
// switched on or off. The model of the drive calls it.
//
//     // By P0C-26 = 1 a 32-bit register has its low word first.
//     word_order order(slice<const std::uint16_t> of_an_init) {
//         return c630s::detail::settings_in(of_an_init).word_order;
//     }
#pragma once

#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/device/c630s/prepared_command.hpp>
#include <servobus/device/c630s/routines.hpp>

namespace servobus::c630s::detail {

/// The state is `needs_init` still: the terminals are read next.
constexpr cached_settings settings_in(slice<const std::uint16_t> w) {
    using namespace routines;
    return {.mode = static_cast<control_mode>(w[mode_word]),
            .word_order = w[pair_word_order_word] == 0 ? word_order::high_first : word_order::low_first,
            .max_speed = w[max_speed_word],
            .max_forward = w[max_forward_word],
            .max_reverse = w[max_reverse_word],
            .positive_torque = w[positive_torque_word],
            .negative_torque = w[negative_torque_word],
            .brake_delay_ms = w[brake_delay_word],
            .power_off_delay_ms = w[power_off_delay_word]};
}
/// A parameter of one word was written.
constexpr void note_parameter(const prepared_command& c, cached_settings& known) {
    const auto address = static_cast<std::uint16_t>(target_speed.address + c.shift);
    if (address == max_speed.address) known.max_speed = c.arguments[0];
    if (address == max_forward_speed.address) known.max_forward = c.arguments[0];
    if (address == max_reverse_speed.address) known.max_reverse = c.arguments[0];
    if (address == positive_internal_torque_limit.address) known.positive_torque = c.arguments[0];
    if (address == negative_internal_torque_limit.address) known.negative_torque = c.arguments[0];
    if (address == brake_on_to_command_delay.address) known.brake_delay_ms = c.arguments[0];
    if (address == brake_off_to_power_off_delay.address) known.power_off_delay_ms = c.arguments[0];
}
constexpr void note_enabled(const prepared_command& c, slice<const std::uint16_t> words,
                            cached_settings& known) {
    known.state = drive_state::enabled;
    known.mode = c.mode;
    known.inputs = c.arguments[4];
    known.source = static_cast<position_source>(c.arguments[3]);
    known.ways = static_cast<displacement_type>(words[0]);
    known.runs_speed_segments = c.then == effect::runs_speed_segments;
    known.run = static_cast<segment_mode>(c.arguments[known.runs_speed_segments ? 2 : 1]);
}
/// The servo is off. Steps that are put into `c` follow: details of a stop, or the reset of a fault.
constexpr void note_servo_off(prepared_command& c, cached_settings& known) {
    known.inputs = c.arguments[1];
    known.runs_speed_segments = false;
    known.run = segment_mode::by_input;
    if (known.state == drive_state::enabled || known.state == drive_state::quick_stopped)
        known.state = drive_state::disabled;
    if (!known.is_initialised()) return;
    if (c.then == effect::stopped) c = {.steps = routines::details, .then = effect::seen};
    if (c.then != effect::disabled_for_reset) return;
    const bool is_set_up = known.state == drive_state::disabled;
    c = {.steps = is_set_up ? routine{routines::fault_reset} : routine{routines::fault_reset_before_set_up},
         .arguments = {known.inputs, is_set_up ? terminal::marker : std::uint16_t{0}},
         .then = effect::reset};
}

} // namespace servobus::c630s::detail
