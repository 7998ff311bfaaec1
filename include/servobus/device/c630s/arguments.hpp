// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the arguments of each command with the register that takes them and their limits. Programs that ask
// `why` a command was refused include it; no other header does.
//
//     constexpr velocity fast{5500 * r_per_min};
//     const refusal r = why(servo, fast); // after `begin` or `run` has refused it
//     if (r.is_of_value() && r.argument.limited_by == c630s::max_forward_speed.address)
//         std::printf("P06-08 allows %ld r/min\n", long(r.argument.limits.high));
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/why.hpp>
#include <servobus/device/c630s/commands.hpp>
#include <servobus/device/c630s/moves.hpp>
#include <servobus/device/c630s/parameters.hpp>
#include <servobus/device/c630s/single_parameters.hpp>

namespace servobus::c630s {

/// Lists the states that the cached settings may have.
constexpr drive_states planned_states(const cached_settings&) {
    return drive_states{drive_state::needs_init, drive_state::needs_set_up, drive_state::needs_power_cycle,
                        drive_state::disabled,   drive_state::enabled,      drive_state::quick_stopped};
}
/// Lists the settings that `enable_in` and `run_speed_segments` choose, and a flag of P31-00: a jog is under way.
constexpr void conditions(cached_settings& known, each_condition& each) {
    bool is_jogging = known.is_jogging();
    each.of<mode_of_operation>(known.mode, control_mode::speed, control_mode::torque);
    each.of<position_command_source>(known.source);
    if (known.runs_speed_segments) {
        each.of<speed_segment_mode>(known.run, segment_mode::single, segment_mode::sequential);
    } else {
        each.of<position_segment_mode>(known.run);
    }
    each.of<speed_command_selection>(known.runs_speed_segments, false, true);
    each.flag<virtual_input_levels>(is_jogging);
    if (is_jogging != known.is_jogging()) {
        known.inputs &= static_cast<std::uint16_t>(~(terminal::jog_forward | terminal::jog_reverse));
        if (is_jogging) known.inputs |= terminal::jog_forward;
    }
}

namespace detail {
inline constexpr std::int64_t no_limit = 0x8000'0000;

/// P06-07 limits a speed either way, P06-08 forward, P06-09 in reverse.
constexpr command_argument in_top_speeds(command_argument a, const cached_settings& known) {
    return a.within<max_forward_speed>(-no_limit, known.max_forward)
        .within<max_reverse_speed>(-std::int64_t{known.max_reverse}, no_limit)
        .within<max_speed>(-std::int64_t{known.max_speed}, known.max_speed);
}
template <const auto& R> constexpr command_argument moved_by(std::uint16_t offset, command_argument a) {
    a.address = a.limited_by = static_cast<std::uint16_t>(R.address + offset);
    return a;
}
/// The time that a homing may take is the program's own, in ms.
constexpr auto homing_arguments(time within) {
    return argument_list{commands::number(within.count(), 1, 2'000'000)};
}
} // namespace detail

// Commands of motion

constexpr auto arguments(const enable_in& c, const cached_settings&) {
    constexpr auto last = static_cast<std::int64_t>(control_mode::torque);
    const command_argument mode = commands::argument<mode_of_operation>(c.mode);
    return argument_list{mode.within(0, last).refused_as(errc::bad_argument),
                         commands::argument<position_segment_mode>(c.run_segments),
                         commands::argument<position_command_source>(c.positions)};
}
constexpr auto arguments(const run_speed_segments& c, const cached_settings&) {
    return argument_list{commands::argument<speed_segment_mode>(c.run),
                         commands::checked_index(c.from, 1, 16), commands::checked_index(c.last, 1, 16)};
}
constexpr auto arguments(const motor_velocity& c, const cached_settings& known) {
    return argument_list{detail::in_top_speeds(commands::argument<target_speed>(c.target), known)};
}
constexpr auto arguments(const held_velocity& c, const cached_settings& known) {
    return arguments(motor_velocity{c.target}, known);
}
constexpr auto arguments(const torque& c, const cached_settings& known) {
    const command_argument target = commands::argument<target_torque>(c.target);
    return argument_list{
        target.within<positive_internal_torque_limit>(-detail::no_limit, known.positive_torque)
            .within<negative_internal_torque_limit>(-std::int64_t{known.negative_torque}, detail::no_limit)};
}
/// P06-04 takes the size of the speed.
constexpr auto arguments(const jog& c, const cached_settings& known) {
    const bool is_reverse = c.at.count() < 0;
    const command_argument size = commands::argument<jog_speed>(is_reverse ? -c.at : c.at);
    const command_argument limited = is_reverse ? size.within<max_reverse_speed>(0, known.max_reverse)
                                                : size.within<max_forward_speed>(0, known.max_forward);
    return argument_list{limited.within<max_speed>(0, known.max_speed)};
}

// Segments and homing

constexpr auto arguments(const segment& c, const cached_settings&) {
    const std::size_t n = c.number.index();
    const command_argument ramp =
        commands::counted_argument<servobus::at<position_segment_acceleration_times, 0>>(c.ramp.count());
    const command_argument wait =
        commands::counted_argument<servobus::at<position_segment_wait_times, 0>>(c.wait.count());
    return argument_list{commands::checked_index(c.number, 1, 16),
                         commands::argument<position_segment_displacements>(n, c.way),
                         commands::argument<position_segment_speeds>(n, c.at),
                         commands::for_element<position_segment_acceleration_times>(n, ramp),
                         commands::for_element<position_segment_wait_times>(n, wait)};
}
constexpr auto arguments(const position_segments& c, const cached_settings&) {
    return argument_list{commands::checked_index(c.last, 1, 16),
                         commands::argument<position_segment_remainder>(c.remainder),
                         commands::argument<position_segment_type>(c.type),
                         commands::argument<first_position_segment>(c.first)};
}
constexpr auto arguments(const start_segment& c, const cached_settings&) {
    return argument_list{commands::checked_index(c.number, 1, 16)};
}
constexpr auto arguments(const select_speed_segment& c, const cached_settings&) {
    return argument_list{commands::checked_index(c.number, 1, 16)};
}
constexpr auto arguments(const step_size& c, const cached_settings&) {
    return argument_list{commands::argument<position_step>(c.way)};
}
constexpr auto arguments(const homing_by& c, const cached_settings&) {
    return argument_list{
        commands::argument<homing_method>(c.mode), commands::argument<homing_high_speed>(c.fast),
        commands::argument<homing_low_speed>(c.slow), commands::argument<homing_acceleration_time>(c.ramp)};
}
constexpr auto arguments(const home& c, const cached_settings&) { return detail::homing_arguments(c.within); }
constexpr auto arguments(const home_electrically& c, const cached_settings&) {
    return detail::homing_arguments(c.within);
}

// Parameters

constexpr auto arguments(const ramps& c, const cached_settings&) {
    return argument_list{commands::argument<acceleration_time>(c.acceleration),
                         commands::argument<deceleration_time>(c.deceleration)};
}
constexpr auto arguments(const torque_limits& c, const cached_settings&) {
    return argument_list{commands::argument<positive_internal_torque_limit>(c.positive),
                         commands::argument<negative_internal_torque_limit>(c.negative)};
}
constexpr auto arguments(const torque_speed_limits& c, const cached_settings&) {
    return argument_list{commands::argument<forward_speed_limit>(c.forward),
                         commands::argument<reverse_speed_limit>(c.reverse)};
}
constexpr auto arguments(const top_speeds& c, const cached_settings&) {
    return argument_list{commands::argument<max_speed>(c.either_way),
                         commands::argument<max_forward_speed>(c.forward),
                         commands::argument<max_reverse_speed>(c.reverse)};
}
constexpr auto arguments(const gear& c, const cached_settings&) {
    constexpr std::uint16_t to_gear_2 = gear_2_numerator.address - gear_1_numerator.address;
    const std::uint16_t offset = c.which == 2 ? to_gear_2 : std::uint16_t{0};
    return argument_list{
        detail::moved_by<gear_1_numerator>(offset, commands::argument<gear_1_numerator>(c.numerator)),
        detail::moved_by<gear_1_denominator>(offset, commands::argument<gear_1_denominator>(c.denominator)),
        commands::index(c.which, 1, 2)};
}
/// P12-21 counts tenths of a second.
constexpr auto arguments(const speed_segment& c, const cached_settings&) {
    const std::size_t n = c.number.index();
    const std::int32_t tenths = c.run_time.count() / 100;
    const bool is_exact = tenths * 100 == c.run_time.count();
    const std::int64_t below = is_exact || c.run_time.count() > 0 ? tenths : tenths - 1;
    const command_argument run_time =
        commands::counted_argument<servobus::at<speed_segment_run_times, 0>>(below, is_exact);
    return argument_list{commands::checked_index(c.number, 1, 16),
                         commands::argument<speed_segment_speeds>(n, c.at),
                         commands::for_element<speed_segment_run_times>(n, run_time),
                         commands::argument<speed_segment_ramps>(n, c.ramp)};
}
constexpr auto arguments(const segment_ramp_times& c, const cached_settings&) {
    const auto ramp = static_cast<std::uint16_t>(c.ramp);
    const auto offset = static_cast<std::uint16_t>(ramp >= 1 && ramp <= 4 ? 2 * (ramp - 1) : 0);
    return argument_list{detail::moved_by<segment_acceleration_time_1>(
                             offset, commands::argument<segment_acceleration_time_1>(c.acceleration)),
                         detail::moved_by<segment_deceleration_time_1>(
                             offset, commands::argument<segment_deceleration_time_1>(c.deceleration)),
                         commands::index(ramp, 1, 4)};
}
/// The function servo-on is given to no wired input.
template <const auto& R> constexpr auto arguments(const set<R>& c, const cached_settings&) {
    using type = typename servobus::row_type<R>::value_type;
    constexpr bool is_input = std::is_same_v<type, input_function>;
    const bool is_servo_on = is_input && c.value.bits() == static_cast<u32>(input_function::servo_on);
    return argument_list{commands::argument<R>(c.value).only_if(!is_servo_on)};
}
template <const auto& R> constexpr auto arguments(const keep<R>& c, const cached_settings& known) {
    return arguments(set<R>{c.value}, known);
}
constexpr auto arguments(const change_address& c, const cached_settings&) {
    return argument_list{commands::argument<node_address>(c.to)};
}
constexpr auto arguments(const change_line& c, const cached_settings&) {
    return argument_list{commands::argument<rs485_baud_rate>(c.baud),
                         commands::argument<data_format>(c.format)};
}

} // namespace servobus::c630s
