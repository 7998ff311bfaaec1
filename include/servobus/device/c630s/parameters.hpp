// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the commands that set it up: ramps and limits, gear, speed segments, encoder and factory resets,
// address and line; any other parameter is in single_parameters.hpp. servobus/device/c630s.hpp includes it. Source:
// manual V24.111, chapters 5 to 9.
//
//     if (!servo.run(c630s::ramps{500 * millisecond, 800 * millisecond})) return 1; // until the power goes
//     if (!servo.run(c630s::top_speeds{3000 * r_per_min, 3000 * r_per_min, 500 * r_per_min})) return 1;
#pragma once

#include <cstdint>

#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

// Set while it works, and gone with the power: P0C-13 is read to be 0 first.

/// Ramps of the speed target, P06-05 and P06-06, 0..65535 ms; what speed they lead to is not stated.
struct ramps {
    time acceleration;
    time deceleration;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_pair<acceleration_time>(routines::ramps, acceleration, deceleration, cached);
    }
};

/// Internal torque limits, P07-09 and P07-10, 0..300.0 %; they hold where P07-07 says so, as from the
/// factory.
struct torque_limits {
    torque_share positive;
    torque_share negative;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::set_pair<positive_internal_torque_limit>(routines::torque_limits,
                                                                              positive, negative, cached);
        o.then = effect::torque_limited;
        return o;
    }
};

/// Speed limits of the torque mode, P07-19 and P07-20, 0..6000 r/min; they hold where P07-17 says so, as from
/// the factory.
struct torque_speed_limits {
    speed forward;
    speed reverse;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_pair<forward_speed_limit>(routines::torque_speed_limits, forward, reverse, cached);
    }
};

/// P06-07 to P06-09, 0..6000 r/min: the highest speed either way, forward and in reverse.
struct top_speeds {
    speed either_way;
    speed forward;
    speed reverse;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto e = detail::count_in<max_speed>(either_way);
        const auto f = detail::count_in<max_forward_speed>(forward);
        const auto r = detail::count_in<max_reverse_speed>(reverse);
        return {.steps = routines::top_speeds,
                .arguments = {detail::as_word(e.count), detail::as_word(f.count), detail::as_word(r.count)},
                .then = effect::speed_limited,
                .refusal = detail::first_error(detail::needs_init_done(cached), e.error, f.error, r.error)};
    }
};

/// The first or second electronic gear, P05-07 to P05-14: encoder counts per reference unit, as a fraction.
/// It acts while P05-02 is 0 (`keep<pulses_per_revolution>{0}`, from the next power-on), which it is not from
/// the factory. While it changes, the position of a running move is not promised.
struct gear {
    std::uint32_t numerator;   ///< 1..1073741824; a turn of the 17-bit encoder is 131072 counts [errata C33]
    std::uint32_t denominator; ///< 1..1073741824
    unsigned which = 1;        ///< 1, or 2, which FunIN.24 chooses

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const word_pair n = split_words(numerator, cached.word_order);
        const word_pair d = split_words(denominator, cached.word_order);
        const std::uint16_t shift = which == 2
                                        ? detail::as_word(gear_2_numerator.address - gear_1_numerator.address)
                                        : std::uint16_t{0};
        return {.steps = routines::gear,
                .arguments = {n.first, n.second, d.first, d.second, 0, detail::word_order_value(cached)},
                .then = effect::pair_set,
                .refusal = detail::first_error(detail::needs_word_order(cached),
                                               detail::in_range<gear_1_numerator>(numerator),
                                               detail::in_range<gear_1_denominator>(denominator),
                                               which == 1 || which == 2 ? errc::ok : errc::bad_argument),
                .shift = shift};
    }
};

/// A speed segment, with the servo off: the drive takes it only then [errata C58]. Run times count as
/// seconds: a drive that was set to minutes refuses it (`wrong_state`).
struct speed_segment {
    segment_number number;
    speed at;                               ///< +-6000 r/min
    time run_time;                          ///< 0..6553.5 s in tenths of a second
    segment_ramp ramp = segment_ramp::none; ///< one of `segment_ramp_times`

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto v = detail::count_in<servobus::at<speed_segment_speeds, 0>>(at);
        const std::int32_t tenths = run_time.count() / 100;
        const errc inexact = tenths * 100 == run_time.count() ? errc::ok : errc::inexact;
        return {.steps = routines::speed_segment,
                .arguments = {detail::as_word(v.count), detail::as_word(tenths), detail::as_word(ramp)},
                .refusal =
                    detail::first_error(detail::needs_servo_off(cached), number.error(), v.error, inexact,
                                        detail::in_range<servobus::at<speed_segment_run_times, 0>>(tenths),
                                        detail::in_range<servobus::at<speed_segment_ramps, 0>>(ramp)),
                .shift = static_cast<std::uint16_t>(number.index() * speed_segment_speeds.stride)};
    }
};

/// One of the four pairs of ramps of the speed segments, P12-03 to P12-10, 0..65535 ms; with the servo off.
struct segment_ramp_times {
    segment_ramp ramp;
    time acceleration;
    time deceleration;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::set_pair<segment_acceleration_time_1>(
            routines::segment_ramp_times, acceleration, deceleration, cached);
        const auto number = static_cast<unsigned>(ramp);
        const errc wrong = number >= 1 && number <= 4 ? errc::ok : errc::bad_argument;
        o.refusal = detail::first_error(detail::needs_servo_off(cached), o.refusal, wrong);
        o.shift = static_cast<std::uint16_t>(2 * (number - 1));
        return o;
    }
};

// What is done once, with the servo off

/// Er.731, Er.733 and Er.735 of the absolute encoder: P0D-20 = 2, then P0D-01. **The position of the turns is
/// lost**: home again. Er.733 and Er.735 want the power off and on afterwards.
struct reset_encoder {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_set_up = cached.state == drive_state::disabled;
        return {.steps = is_set_up ? routine{routines::reset_encoder}
                                   : routine{routines::reset_encoder_before_set_up},
                .refusal = detail::first_error(
                    detail::needs_servo_off(cached),
                    cached.state == drive_state::needs_power_cycle ? errc::wrong_state : errc::ok)};
    }
};

/// Forgets the faults that P0B-33 shows, P02-31 = 2.
struct clear_fault_history {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::clear_fault_records, .refusal = detail::needs_servo_off(cached)};
    }
};

/// Software reset, P0D-00. Nothing is known of the drive afterwards. Whether it counts as a power cycle
/// for the parameters that want one is not stated.
struct restart {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::restart,
                .then = effect::forgotten,
                .refusal = detail::needs_servo_off(cached)};
    }
};

using servobus::sole_drive_on_the_line;

/// Restores the factory's parameters, P02-31 = 1, all but the groups P00 and P01. Switch the drive off and
/// on; then it is presumably at **address 1, 57600 Bd, 8N2** [errata C39], keeps every write in its EEPROM,
/// and wants `init` and `set_up` again. Nothing is known of it afterwards.
struct factory_reset {
    constexpr explicit factory_reset(sole_drive_on_the_line) {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::factory_reset,
                .then = effect::forgotten,
                .refusal = detail::needs_servo_off(cached)};
    }
};

/// Gives the drive another address, P0C-00, in the EEPROM; it applies immediately. Whether the response comes
/// from the old or the new address is not stated, so the outcome is usually `unknown`. The state is `needs_init`
/// afterwards; `init` of a facade at the new address finds the drive, and sets P0C-13 to 0 again.
struct change_address {
    std::uint16_t to; ///< 1..247

    constexpr change_address(std::uint16_t address, sole_drive_on_the_line) : to{address} {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::change_address,
                .arguments = {to},
                .then = effect::forgotten,
                .refusal =
                    detail::first_error(detail::needs_servo_off(cached), detail::in_range<node_address>(to))};
    }
};

/// Another baud rate and format, P0C-02 and P0C-03, in the EEPROM; they apply immediately. It ends as
/// `change_address` does; open the port anew. `servobus::change_baud_rate` finds out where the drive answers.
struct change_line {
    baud_rate baud;
    serial_format format = serial_format::n82;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::change_line,
                .arguments = {detail::as_word(baud), detail::as_word(format)},
                .then = effect::forgotten,
                .refusal = detail::first_error(detail::needs_servo_off(cached),
                                               detail::in_range<rs485_baud_rate>(baud),
                                               detail::in_range<data_format>(format))};
    }
};

} // namespace servobus::c630s
