// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the arguments of each command with the register that takes them and their limits. Programs that ask
// `why` a command was refused include it; no other header does.
//
//     constexpr velocity fast{900 * r_per_min, 0 * r_per_min};
//     const refusal r = why(wheels, fast); // after `begin` or `run` has refused it
//     if (r.is_of_value() && r.argument.limited_by == zlac8015d::max_motor_speed.address)
//         std::printf("2008h allows %ld counts\n", long(r.argument.limits.high));
#pragma once

#include <cstdint>

#include <servobus/control/why.hpp>
#include <servobus/device/zlac8015d/commands.hpp>
#include <servobus/device/zlac8015d/parameters.hpp>
#include <servobus/device/zlac8015d/single_parameters.hpp>

namespace servobus::zlac8015d {

/// Lists the states that the cached settings may have.
constexpr drive_states planned_states(const cached_settings&) {
    return drive_states{drive_state::needs_init, drive_state::needs_power_cycle, drive_state::disabled,
                        drive_state::enabled, drive_state::quick_stopped};
}
/// Lists the settings that `enable_in` chooses, and that the watchdog's time (2000h) is not 0.
constexpr void conditions(cached_settings& known, each_condition& each) {
    each.of<mode_of_operation>(known.mode);
    each.of<position_synchronisation>(known.starts);
    bool has_watchdog = known.host_timeout != 0;
    each.flag<host_timeout>(has_watchdog);
    known.host_timeout = has_watchdog ? u16{1} : u16{0};
}

namespace detail {
/// Converts a speed to counts of 1/n r/min, where n is 2022h. Its limit is 2008h.
template <const auto& R> constexpr command_argument speed_argument(speed v, const cached_settings& known) {
    const std::int64_t scaled = std::int64_t{v.count()} * known.resolution;
    const std::int64_t whole = scaled / 2520;
    const bool is_exact = whole * 2520 == scaled;
    const std::int64_t most = std::int64_t{known.max_speed} * known.resolution;
    const std::int64_t below = is_exact || scaled > 0 ? whole : whole - 1;
    const command_argument a = commands::counted_argument<R>(below, is_exact);
    return a.within<max_motor_speed>(-most, most);
}
template <const auto& R> constexpr command_argument way_argument(distance way) {
    return commands::argument<R>(way).within(-longest_way, longest_way);
}
template <const auto& R> constexpr command_argument absolute_argument(distance place) {
    const command_argument a = commands::argument<R>(place);
    return a.within(-farthest_place, farthest_place);
}
} // namespace detail

// Commands of motion

constexpr auto arguments(const enable_in& c, const cached_settings&) {
    constexpr auto first = static_cast<std::int64_t>(operating_mode::relative_position);
    constexpr auto last = static_cast<std::int64_t>(operating_mode::torque);
    const command_argument mode = commands::argument<mode_of_operation>(c.mode.mode());
    return argument_list{mode.within(first, last).refused_as(errc::bad_argument)};
}
constexpr auto arguments(const wheel_velocities& c, const cached_settings& known) {
    return argument_list{detail::speed_argument<left_target_speed>(c.left, known),
                         detail::speed_argument<right_target_speed>(c.right, known)};
}
constexpr auto arguments(const held_velocities& c, const cached_settings& known) {
    return arguments(wheel_velocities{c.left, c.right}, known);
}
constexpr auto arguments(const left_velocity& c, const cached_settings& known) {
    return argument_list{detail::speed_argument<left_target_speed>(c.left, known)};
}
constexpr auto arguments(const right_velocity& c, const cached_settings& known) {
    return argument_list{detail::speed_argument<right_target_speed>(c.right, known)};
}
constexpr auto arguments(const torque& c, const cached_settings&) {
    return argument_list{commands::argument<left_target_torque>(c.left),
                         commands::argument<right_target_torque>(c.right)};
}
constexpr auto arguments(const left_torque& c, const cached_settings&) {
    return argument_list{commands::argument<left_target_torque>(c.left)};
}
constexpr auto arguments(const right_torque& c, const cached_settings&) {
    return argument_list{commands::argument<right_target_torque>(c.right)};
}
constexpr auto arguments(const wheel_ways& c, const cached_settings&) {
    return argument_list{detail::way_argument<left_target_position>(c.left),
                         detail::way_argument<right_target_position>(c.right)};
}
constexpr auto arguments(const move_left_by& c, const cached_settings&) {
    return argument_list{detail::way_argument<left_target_position>(c.left)};
}
constexpr auto arguments(const move_right_by& c, const cached_settings&) {
    return argument_list{detail::way_argument<right_target_position>(c.right)};
}
constexpr auto arguments(const wheel_places& c, const cached_settings&) {
    return argument_list{detail::absolute_argument<left_target_position>(c.left),
                         detail::absolute_argument<right_target_position>(c.right)};
}
constexpr auto arguments(const move_left_to& c, const cached_settings&) {
    return argument_list{detail::absolute_argument<left_target_position>(c.left)};
}
constexpr auto arguments(const move_right_to& c, const cached_settings&) {
    return argument_list{detail::absolute_argument<right_target_position>(c.right)};
}

// Parameters

constexpr auto arguments(const ramps& c, const cached_settings&) {
    return argument_list{commands::argument<left_acceleration_time>(c.acceleration),
                         commands::argument<left_deceleration_time>(c.deceleration)};
}
constexpr auto arguments(const quick_stop_ramp& c, const cached_settings&) {
    return argument_list{commands::argument<left_quick_stop_time>(c.deceleration)};
}
constexpr auto arguments(const quick_stop_by& c, const cached_settings&) {
    return argument_list{commands::argument<quick_stop_option_code>(c.option)};
}
constexpr auto arguments(const torque_slope& c, const cached_settings&) {
    return argument_list{commands::argument<left_torque_slope>(c.slope)};
}
constexpr auto arguments(const position_speed& c, const cached_settings&) {
    return argument_list{commands::argument<left_max_speed>(c.left),
                         commands::argument<right_max_speed>(c.right)};
}
constexpr auto arguments(const brakes& c, const cached_settings&) {
    return argument_list{commands::argument<left_brake>(c.left), commands::argument<right_brake>(c.right)};
}
constexpr auto arguments(const on_input_stop& c, const cached_settings&) {
    return argument_list{commands::argument<input_stop>(c.action)};
}
constexpr auto arguments(const park& c, const cached_settings&) {
    return argument_list{commands::argument<parking_mode>(c.parking)};
}
constexpr auto arguments(const clear_position& c, const cached_settings&) {
    return argument_list{commands::argument<clear_feedback_position>(c.of)};
}
constexpr auto arguments(const watchdog& c, const cached_settings&) {
    return argument_list{commands::argument<host_timeout>(c.limit).or_if(c.is_zero_by_name)};
}
constexpr auto arguments(const resolution& c, const cached_settings&) {
    return argument_list{commands::argument<speed_resolution>(c.n)};
}
template <const auto& R> constexpr auto arguments(const set<R>& c, const cached_settings&) {
    return argument_list{commands::argument(c.value)};
}
/// A rated current above the maximum is refused by `bad_argument`.
constexpr auto arguments(const current_limits& c, const cached_settings&) {
    const command_argument most = commands::argument<left_max_current>(c.most);
    return argument_list{commands::argument<left_rated_current>(c.rated), most,
                         most.refused_as(errc::bad_argument).only_if(c.rated.count() <= c.most.count())};
}

} // namespace servobus::zlac8015d
