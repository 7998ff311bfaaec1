// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: any parameter by its row, read back; and the currents of both motors. servobus/device/zlac8015d.hpp
// includes it. Source: RS485 manual V1.07, section 4, which does not state when a parameter may be written: the rules
// here are on the safe side.
//
//     if (!wheels.run(zlac8015d::current_limits{12 * ampere, 24 * ampere})) return 1; // while disabled
//     if (!wheels.run(zlac8015d::set<zlac8015d::left_speed_kp>{600})) return 1;       // while the wheel turns, too
//     if (!wheels.run(zlac8015d::save{})) return 1;
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/setting_commands.hpp>
#include <servobus/device/zlac8015d/prepared_command.hpp>

namespace servobus::zlac8015d {

using servobus::commands::keep, servobus::commands::set;

namespace routines {
/// A parameter that may change while the wheels turn.
template <const auto& R>
inline constexpr step set_row[] = {steps::write_arguments<R>(), steps::expect_arguments<R>()};
template <const auto& R>
inline constexpr step set_row_at_rest[] = {must_stand, steps::write_arguments<R>(),
                                           steps::expect_arguments<R>()};
/// Argument 1, beside the resolution.
inline constexpr step set_top_speed[] = {must_stand, steps::write_arguments<max_motor_speed>(1),
                                         steps::expect_arguments<max_motor_speed>(1)};

/// Rated and maximum current of both motors.
inline constexpr step current_limits[] = {
    must_stand,
    steps::write_arguments<left_rated_current, left_max_current>(),
    steps::expect_arguments<left_rated_current, left_max_current>(),
    steps::write_arguments<right_rated_current, right_max_current>(),
    steps::expect_arguments<right_rated_current, right_max_current>(),
};
} // namespace routines

namespace detail {
/// Each row that `set` does not take has a command of its own.
template <const auto& R> constexpr void check_settable() {
    static_assert(std::is_same_v<typename row_type<R>::device, device>,
                  "this register belongs to another device");
    static_assert(!has(R.flags, flag::communication),
                  "a setting of the line is no parameter: change_address and change_baud_rate write it");
    static_assert(!has(R.flags, flag::trigger) &&
                      !commands::is_one_of<R, mode_of_operation, position_synchronisation>,
                  "a command of the drive writes this register: enable_in, save, clear_position, ...");
    static_assert(!has(R.flags, flag::motion),
                  "a target is no parameter: velocity, torque and the moves set it");
    static_assert(!commands::is_one_of<R, host_timeout>, "the watchdog's time is set by watchdog{}");
    static_assert(!commands::is_one_of<R, speed_resolution>,
                  "the resolution of speeds is set by resolution{}");
    static_assert(!commands::is_one_of<R, left_acceleration_time, right_acceleration_time,
                                       left_deceleration_time, right_deceleration_time>,
                  "the ramps of both wheels are set by ramps{}");
    static_assert(!commands::is_one_of<R, left_quick_stop_time, right_quick_stop_time>,
                  "the ramps of a quick stop are set by quick_stop_ramp{}");
    static_assert(!commands::is_one_of<R, quick_stop_option_code>,
                  "what a quick stop does is set by quick_stop_by{}");
    static_assert(!commands::is_one_of<R, left_torque_slope, right_torque_slope>,
                  "the slopes of the torques are set by torque_slope{}");
    static_assert(!commands::is_one_of<R, left_max_speed, right_max_speed>,
                  "the top speeds of the position modes are set by position_speed{}");
    static_assert(!commands::is_one_of<R, left_brake, right_brake>, "the brake outputs are set by brakes{}");
    static_assert(!commands::is_one_of<R, input_stop>,
                  "what the shafts do after a wired stop is set by on_input_stop{}");
    static_assert(!commands::is_one_of<R, parking_mode>, "the parking mode is set by park{}");
}

/// The registers of the right motor are 30h after those of the left one.
constexpr std::uint16_t as_of_left(std::uint16_t address) {
    const bool is_right = address >= right_encoder_lines.address && address <= right_speed_observer_4.address;
    return is_right ? as_word(address - right_encoder_lines.address + left_encoder_lines.address) : address;
}
/// True for what is tuned while the wheels turn: gains, filters, currents and protection of a motor.
constexpr bool may_be_tuned(std::uint16_t address) {
    const std::uint16_t left = as_of_left(address);
    return (left >= left_overload_factor.address && left <= left_position_kf.address) ||
           (left >= left_motor_temperature_limit.address && left <= left_speed_observer_4.address) ||
           address == driver_temperature_limit.address;
}
/// True for the encoder lines, which change the counts of a turn.
constexpr bool changes_counts(std::uint16_t address) {
    return as_of_left(address) == left_encoder_lines.address;
}
} // namespace detail

/// Gains (2037h..2040h, 2047h..204Ah; right: 30h more), currents and overload (2032h..2035h), the limit of the
/// following error (2036h) and temperature limits (2046h, 201Eh) are set in each state after `init`, all others while
/// the drive is disabled and both wheels stand (`wrong_state`, `busy`). After the encoder lines (2030h) the state is
/// `needs_init`, since a turn has another number of counts.
template <const auto& R>
constexpr prepared_command prepare(const set<R>& wanted, const cached_settings& cached) {
    detail::check_settable<R>();
    constexpr bool is_tuned = detail::may_be_tuned(R.address);
    const errc state = is_tuned ? detail::needs_init_done(cached) : detail::needs_disabled(cached);
    const std::uint16_t word = detail::as_word(wanted.value.bits());
    const errc refusal = detail::first_error(state, wanted.value.error());
    if constexpr (commands::is_one_of<R, max_motor_speed>) {
        return {.steps = routines::set_top_speed,
                .arguments = {cached.resolution, word},
                .then = effect::speeds_set,
                .refusal = refusal};
    } else if constexpr (is_tuned) {
        return {.steps = routines::set_row<R>, .arguments = {word}, .refusal = refusal};
    } else {
        return {.steps = routines::set_row_at_rest<R>,
                .arguments = {word},
                .then = detail::changes_counts(R.address) ? effect::forgotten : effect::none,
                .refusal = refusal};
    }
}
template <const auto& R> constexpr prepared_command prepare(const keep<R>&, const cached_settings&) {
    static_assert(row_type<R>::words == 0,
                  "this drive keeps all its parameters together: set this one, then save{}");
    return {.steps = no_steps};
}

/// Sets rated and maximum current of both motors, 2033h, 2034h, 2063h, 2064h: 0..15.0 A and 0..30.0 A, in tenths; while
/// disabled, at standstill. Errors: `bad_argument` if the rated current is above the maximum.
struct current_limits {
    current rated;
    current most;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto r = detail::count_in<left_rated_current>(rated);
        const auto m = detail::count_in<left_max_current>(most);
        return {.steps = routines::current_limits,
                .arguments = {detail::as_word(r.count), detail::as_word(m.count)},
                .refusal =
                    detail::first_error(detail::needs_disabled(cached), detail::first_error(r.error, m.error),
                                        r.count > m.count ? errc::bad_argument : errc::ok)};
    }
};

} // namespace servobus::zlac8015d
