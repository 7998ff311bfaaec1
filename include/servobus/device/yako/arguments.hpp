// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the arguments of each command with the register that takes them and their limits. Programs
// that ask `why` a command was refused include it; no other header does.
//
//     constexpr velocity slow{5 * r_per_min};
//     const refusal r = why(axis, slow); // after `begin` or `run` has refused it
//     if (r.is_of_state() && r.unmet() != nullptr)
//         std::printf("set %04Xh first\n", unsigned{r.unmet()->address});
#pragma once

#include <cstdint>

#include <servobus/control/why.hpp>
#include <servobus/device/yako/hold.hpp>
#include <servobus/device/yako/parameters.hpp>
#include <servobus/device/yako/single_parameters.hpp>

namespace servobus::yako {

/// Lists what must be certain of the drive's speeds: the worth of a count (001Ah), and that the stored profile (0020h)
/// and the homing speeds (0032h) are in that count.
constexpr void conditions(cached_settings& known, each_condition& each) {
    each.flag<closed_loop::speed_resolution>(known.has_scale);
    each.flag<closed_loop::start_speed>(known.has_profile);
    each.flag<closed_loop::homing_fast_speed>(known.has_homing_profile);
}

/// The error of what a routine reads first, if the drive is as the program knows it.
constexpr errc permitted(const prepared_command& c, const cached_settings& known) {
    const bool is_enabled = known.state == drive_state::enabled;
    const bool is_wrong =
        is_enabled ? has(c.needs, requirement::released) : has(c.needs, requirement::enabled);
    if (is_wrong) return errc::wrong_state;
    return has(c.needs, requirement::homed) ? detail::needs_homed(known) : errc::ok;
}

namespace detail {
// A speed is refused for its state, not for its value, while the worth of a count is not certain.
template <const auto& R> constexpr command_argument speed_argument(speed v, const cached_settings& known) {
    const bool is_tenths = known.resolution == speed_count::tenth_r_per_min;
    const std::int32_t whole = is_tenths ? v.count() : v.count() / 10;
    const bool is_exact = is_tenths || v.count() % 10 == 0;
    const std::int32_t scale = is_tenths ? 10 : 1;
    command_argument a =
        commands::counted_argument<R>(is_exact || v.count() > 0 ? whole : std::int64_t{whole} - 1, is_exact);
    a.limits = {.low = R.limits.low * scale, .high = R.limits.high * scale};
    return a;
}
template <const auto& Rows>
constexpr command_argument speed_argument(std::size_t index, speed v, const cached_settings& known) {
    return commands::for_element<Rows>(index, speed_argument<at<Rows, 0>>(v, known));
}
/// Excludes the ends of 32 bits, which a saturated quantity has.
constexpr command_argument way(command_argument a) { return a.within(-0x7FFF'FFFF, 0x7FFF'FFFE); }
template <const auto& R> constexpr command_argument way_argument(distance v) {
    return way(commands::argument<R>(v));
}
constexpr command_argument start_argument(const motion_profile& p, const cached_settings& k) {
    return speed_argument<closed_loop::start_speed>(p.start(), k);
}
constexpr command_argument top_argument(const motion_profile& p, const cached_settings& k) {
    return speed_argument<closed_loop::positioning_speed>(p.top(), k).only_if(p.has_order());
}
} // namespace detail

// Commands of motion

constexpr auto arguments(const relative_move& c, const cached_settings& known) {
    return argument_list{detail::way_argument<target_position>(c.way), detail::start_argument(c.by, known),
                         commands::argument<acceleration_time>(c.by.acceleration()),
                         commands::argument<deceleration_time>(c.by.deceleration()),
                         detail::top_argument(c.by, known)};
}
constexpr auto arguments(const absolute_move& c, const cached_settings& known) {
    return arguments(relative_move{c.place, c.by}, known);
}
constexpr auto arguments(const bounded_jog& c, const cached_settings& known) {
    return arguments(relative_move{c.way, c.by}, known);
}
constexpr auto arguments(const held_velocity& c, const cached_settings& known) {
    const speed top = c.target.count() < 0 ? -c.target : c.target;
    const command_argument to = detail::speed_argument<closed_loop::positioning_speed>(top, known);
    return argument_list{commands::argument<acceleration_time>(c.acceleration),
                         commands::argument<deceleration_time>(c.deceleration), to.only_if(top.count() != 0),
                         commands::number(c.every.us, shortest_hold.us, longest_hold.us)};
}
constexpr auto arguments(const jog_velocity& c, const cached_settings& known) {
    const command_argument to = detail::speed_argument<closed_loop::jog_speed>(c.target, known);
    return argument_list{to.only_if(c.target.count() != 0),
                         commands::argument<jog_acceleration_time>(c.acceleration),
                         commands::argument<jog_deceleration_time>(c.deceleration)};
}
template <class Device> constexpr auto arguments(const basic_home<Device>& c, const cached_settings&) {
    command_argument method = commands::argument<closed_loop::homing_method>(number_of(c.by.method()));
    if (!detail::is_closed_loop<Device>) method.limits = open_loop::homing_method.limits;
    return argument_list{detail::way_argument<home_offset>(c.offset),
                         commands::argument<homing_offset_mode>(c.then),
                         method.only_if(c.by.error() == errc::ok)};
}
constexpr auto arguments(const position_declaration& c, const cached_settings&) {
    return argument_list{detail::way_argument<home_offset>(c.place)};
}

// Profiles and segments

constexpr auto arguments(const set_profile& c, const cached_settings& known) {
    return arguments(relative_move{distance{}, c.to}, known);
}
constexpr auto arguments(const set_homing_profile& c, const cached_settings& known) {
    return argument_list{detail::speed_argument<closed_loop::homing_fast_speed>(c.fast, known),
                         detail::speed_argument<closed_loop::homing_slow_speed>(c.slow, known),
                         commands::argument<homing_ramp_time>(c.ramp)};
}
constexpr auto arguments(const set_position_segment& c, const cached_settings& known) {
    namespace cl = closed_loop;
    const std::size_t n = c.number.index();
    return argument_list{commands::checked_index(c.number, 1, 16),
                         detail::way(commands::argument<position_segment_targets>(n, c.target)),
                         detail::speed_argument<cl::position_segment_speeds>(n, c.top, known),
                         commands::argument<cl::position_segment_acceleration_times>(n, c.acceleration),
                         commands::argument<cl::position_segment_deceleration_times>(n, c.deceleration),
                         commands::argument<position_segment_positionings>(n, c.from)};
}
constexpr auto arguments(const set_speed_segment& c, const cached_settings& known) {
    namespace cl = closed_loop;
    const std::size_t n = c.number.index();
    return argument_list{commands::checked_index(c.number, 1, 16),
                         detail::speed_argument<cl::speed_segment_speeds>(n, c.target, known),
                         commands::argument<cl::speed_segment_acceleration_times>(n, c.acceleration),
                         commands::argument<cl::speed_segment_deceleration_times>(n, c.deceleration)};
}
constexpr auto arguments(const set_pv_trigger& c, const cached_settings&) {
    return argument_list{commands::argument<pv_trigger_mode>(c.by)};
}
constexpr auto arguments(const set_input_move& c, const cached_settings& known) {
    const auto move = arguments(relative_move{c.target, c.by}, known);
    return argument_list{move.items[0], move.items[1], move.items[2],
                         move.items[3], move.items[4], commands::argument<io_positioning>(c.from)};
}

// Terminals, limits and communication

constexpr auto arguments(const set_input& c, const cached_settings& known) {
    const auto terminal = static_cast<std::uint16_t>(c.terminal);
    command_argument function = commands::argument<x0_function>(c.as);
    function.address = function.limited_by = static_cast<std::uint16_t>(x0_function.address + terminal);
    return argument_list{commands::index(terminal, 0, known.is_closed_loop ? 3 : 6), function};
}
constexpr auto arguments(const set_output& c, const cached_settings& known) {
    const auto terminal = static_cast<std::uint16_t>(c.terminal);
    const bool has_meaning = c.as <= output_function::brake || c.as >= output_function::user_0;
    command_argument function = commands::argument<y0_function>(c.as).only_if(has_meaning);
    function.address = function.limited_by = static_cast<std::uint16_t>(y0_function.address + terminal);
    return argument_list{commands::index(terminal, 0, known.is_closed_loop ? 1 : 2), function};
}
/// The highest place must lie above the lowest one.
constexpr auto arguments(const travel_bounds& c, const cached_settings&) {
    const std::int64_t above = std::int64_t{c.lowest.count()} + 1;
    const command_argument order = commands::argument<positive_software_limit>(c.highest);
    return argument_list{
        order.within<negative_software_limit>(above, 0x7FFF'FFFE).refused_as(errc::bad_argument),
        detail::way_argument<positive_software_limit>(c.highest),
        detail::way_argument<negative_software_limit>(c.lowest)};
}
constexpr auto arguments(const set_over_travel_stop& c, const cached_settings&) {
    return argument_list{commands::argument<over_travel_stop_mode>(c.by)};
}
constexpr auto arguments(const set_word_order& c, const cached_settings&) {
    return argument_list{commands::argument<pair_word_order>(c.to)};
}
constexpr auto arguments(const set_speed_resolution& c, const cached_settings&) {
    return argument_list{commands::argument<closed_loop::speed_resolution>(c.to)};
}
constexpr auto arguments(const set_node_address& c, const cached_settings&) {
    const command_argument to = commands::argument<node_address>(c.address());
    return argument_list{to.within(device::facts.lowest_address, device::facts.highest_address)};
}
constexpr auto arguments(const set_baud_rate& c, const cached_settings&) {
    return argument_list{commands::argument<rs485_baud_rate>(c.to)};
}
constexpr auto arguments(const set_serial_format& c, const cached_settings&) {
    return argument_list{commands::argument<rs485_format>(c.to)};
}

// Single parameters

template <const auto& R> constexpr auto arguments(const set<R>& c, const cached_settings&) {
    return argument_list{commands::argument(c.value)};
}
constexpr auto arguments(const set_microsteps& c, const cached_settings&) {
    return argument_list{commands::argument(c.pulses)};
}
constexpr auto arguments(const set_direction& c, const cached_settings&) {
    return argument_list{commands::argument<motion_direction>(c.to)};
}
constexpr auto arguments(const set_current_loop& c, const cached_settings&) {
    return argument_list{commands::argument(c.kp_multiplier), commands::argument(c.kp),
                         commands::argument(c.ki), commands::argument(c.kc)};
}
constexpr auto arguments(const closed_loop::set_collision_homing& c, const cached_settings&) {
    return argument_list{commands::argument(c.threshold), commands::argument(c.most)};
}

} // namespace servobus::yako
