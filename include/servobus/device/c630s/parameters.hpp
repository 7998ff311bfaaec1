// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the commands that set it up: ramps and limits, gear, speed segments, any other parameter
// with or without the EEPROM, encoder and factory resets, address and line. servobus/device/c630s.hpp
// includes it. Source: manual V24.111, chapters 5 to 9.
//
//     if (!servo.run(c630s::ramps{500 * millisecond, 800 * millisecond})) return 1; // until the power goes
//     const routine_status kept = servo.run(c630s::keep<c630s::di1_function>{c630s::input_function::home_switch});
//     if (kept.error() == errc::already_assigned)
//         std::printf("the register %04Xh has it\n", unsigned{servo.conflicting_terminal()});
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

// Set while it works, and gone with the power: P0C-13 is read to be 0 first.

/// Ramps of the speed target, P06-05 and P06-06, 0..65535 ms; what speed they lead to is not stated.
struct ramps {
    time acceleration;
    time deceleration;
    constexpr prepared_command plan(const cached_settings& cached) const {
        return detail::set_pair<acceleration_time>(routines::ramps, acceleration, deceleration, cached);
    }
};

/// Internal torque limits, P07-09 and P07-10, 0..300.0 %; they hold where P07-07 says so, as from the
/// factory.
struct torque_limits {
    torque_share positive;
    torque_share negative;
    constexpr prepared_command plan(const cached_settings& cached) const {
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
    constexpr prepared_command plan(const cached_settings& cached) const {
        return detail::set_pair<forward_speed_limit>(routines::torque_speed_limits, forward, reverse, cached);
    }
};

/// P06-07 to P06-09, 0..6000 r/min: the highest speed either way, forward and in reverse.
struct top_speeds {
    speed either_way;
    speed forward;
    speed reverse;
    constexpr prepared_command plan(const cached_settings& cached) const {
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

    constexpr prepared_command plan(const cached_settings& cached) const {
        const word_pair n = split_words(numerator, cached.word_order);
        const word_pair d = split_words(denominator, cached.word_order);
        const std::uint16_t shift = which == 2
                                        ? detail::as_word(gear_2_numerator.address - gear_1_numerator.address)
                                        : std::uint16_t{0};
        return {.steps = routines::gear,
                .arguments = {n.first, n.second, d.first, d.second, 0, detail::word_order_value(cached)},
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

    constexpr prepared_command plan(const cached_settings& cached) const {
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

    constexpr prepared_command plan(const cached_settings& cached) const {
        prepared_command o = detail::set_pair<segment_acceleration_time_1>(
            routines::segment_ramp_times, acceleration, deceleration, cached);
        const auto number = static_cast<unsigned>(ramp);
        const errc wrong = number >= 1 && number <= 4 ? errc::ok : errc::bad_argument;
        o.refusal = detail::first_error(detail::needs_servo_off(cached), o.refusal, wrong);
        o.shift = static_cast<std::uint16_t>(2 * (number - 1));
        return o;
    }
};

// Any parameter

namespace detail {
template <const auto& R>
inline constexpr effect effect_of =
    servobus::row_type<R>::words == 2 ? effect::pair_set : effect::parameter_set;

/// `set` and `keep` refuse what the facade sets itself, and what acts immediately.
template <const auto& R> constexpr bool is_plain_parameter() {
    const unsigned group = R.address >> 8;
    const bool is_facade_s =
        group == 0x17 || group >= 0x30 || R.address == mode_of_operation.address ||
        R.address == virtual_inputs_enable.address || R.address == virtual_outputs_enable.address ||
        R.address == virtual_inputs_at_power_on.address || R.address == power_on_functions_1_to_16.address;
    return has(R.flags, flag::saved_on_write) && !has(R.flags, flag::trigger) &&
           !has(R.flags, flag::communication) && !is_facade_s;
}

/// A wired servo-on input would energise the motor without a command of this facade.
template <const auto& R> constexpr errc leaves_servo_on_alone(u32 bits) {
    using type = typename servobus::row_type<R>::value_type;
    if constexpr (std::is_same_v<type, input_function>) {
        return bits == static_cast<u32>(input_function::servo_on) ? errc::out_of_range : errc::ok;
    } else {
        return errc::ok;
    }
}

/// A terminal gets a function: first the others are read that may have it. Arguments of the looks: the
/// function, its register, and whether it is kept.
constexpr prepared_command look_for_rivals(const prepared_command& put, std::uint16_t address, bool is_kept) {
    const terminal_kind kind = terminal_kind_of(address);
    if ((kind != terminal_kind::input && kind != terminal_kind::output) || put.arguments[0] == 0) return put;
    prepared_command o = put;
    o.steps = routines::look_at_block;
    o.arguments = {put.arguments[0], address, static_cast<std::uint16_t>(is_kept)};
    o.then = effect::rivals_seen;
    o.shift = as_word(first_rivals(address) - routines::first_of_blocks);
    return o;
}
template <const auto& R>
constexpr prepared_command put(routine one, routine two, const register_value<R>& value, errc state,
                               const cached_settings& cached) {
    static_assert(is_plain_parameter<R>(), "this register has an order of its own");
    constexpr bool is_pair = servobus::row_type<R>::words == 2;
    constexpr std::uint16_t base = is_pair ? home_offset.address : target_speed.address;
    prepared_command o{.steps = is_pair ? two : one,
                       .arguments = {as_word(value.bits()), 0, 0, 0, 0, word_order_value(cached)},
                       .refusal = first_error(state, is_pair ? needs_word_order(cached) : errc::ok,
                                              value.error(), leaves_servo_on_alone<R>(value.bits())),
                       .shift = static_cast<std::uint16_t>(R.address - base)};
    if constexpr (is_pair) {
        const word_pair words = split_words(value.bits(), cached.word_order);
        o.arguments[0] = words.first;
        o.arguments[1] = words.second;
    }
    return o;
}
} // namespace detail

/// Sets a parameter until the power goes, and reads it back:
/// `run(set<positioning_completed_threshold>{500})`. One that is taken only while the servo is off is refused
/// otherwise; one that counts from the next power-on does not compile: `keep` it.
///
/// A terminal's function, such as `di1_function`, is first compared with those of the other terminals: no two
/// inputs, wired or virtual, and no two wired outputs may have one (Er.130; sections 6.4.1 and 6.4.2).
/// Error: `already_assigned` if another terminal has it; nothing is written then, and
/// `drive::conflicting_terminal()` is the address of the register that holds it. Give that terminal another
/// function first, or none.
template <const auto& R> struct set {
    register_value<R> value;

    constexpr prepared_command plan(const cached_settings& cached) const {
        static_assert(!has(R.flags, flag::after_power_cycle), "this register counts from the next power-on");
        constexpr bool moves = has(R.flags, flag::motion) || has(R.flags, flag::when_stopped);
        const errc state = moves ? detail::needs_servo_off(cached) : detail::needs_init_done(cached);
        prepared_command o = detail::put<R>(routines::set_one, routines::set_two, value, state, cached);
        o.then = detail::effect_of<R>;
        return detail::look_for_rivals(o, R.address, false);
    }
};

/// Sets a parameter for good, with the servo off: P0C-13 = 1, write, read back, P0C-13 = 0. It wears the
/// EEPROM by three writes or so: for set-up. Where it counts from the next power-on, the state is
/// `needs_power_cycle`. A terminal's function is compared with the others as `set` does it, so that the
/// restart does not end in Er.130:
///
///     routine_status got = servo.run(keep<di1_function>{input_function::home_switch});
///     if (got.error() == errc::already_assigned) ... // servo.conflicting_terminal() == "P03-14"_p: DI7
///
/// Error: `already_assigned`.
template <const auto& R> struct keep {
    register_value<R> value;

    constexpr prepared_command plan(const cached_settings& cached) const {
        constexpr bool is_later = has(R.flags, flag::after_power_cycle);
        const routine one = is_later ? routine{routines::keep_one_for_later} : routine{routines::keep_one};
        const routine two = is_later ? routine{routines::keep_two_for_later} : routine{routines::keep_two};
        prepared_command o = detail::put<R>(one, two, value, detail::needs_servo_off(cached), cached);
        o.then = is_later ? effect::needs_power_cycle : detail::effect_of<R>;
        return detail::look_for_rivals(o, R.address, true);
    }
};

// What is done once, with the servo off

/// Er.731, Er.733 and Er.735 of the absolute encoder: P0D-20 = 2, then P0D-01. **The position of the turns is
/// lost**: home again. Er.733 and Er.735 want the power off and on afterwards.
struct reset_encoder {
    constexpr prepared_command plan(const cached_settings& cached) const {
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
    constexpr prepared_command plan(const cached_settings& cached) const {
        return {.steps = routines::clear_fault_records, .refusal = detail::needs_servo_off(cached)};
    }
};

/// Software reset, P0D-00. Nothing is known of the drive afterwards. Whether it counts as a power cycle
/// for the parameters that want one is not stated.
struct restart {
    constexpr prepared_command plan(const cached_settings& cached) const {
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
    constexpr prepared_command plan(const cached_settings& cached) const {
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
    constexpr prepared_command plan(const cached_settings& cached) const {
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

    constexpr prepared_command plan(const cached_settings& cached) const {
        return {.steps = routines::change_line,
                .arguments = {detail::as_word(baud), detail::as_word(format)},
                .then = effect::forgotten,
                .refusal = detail::first_error(detail::needs_servo_off(cached),
                                               detail::in_range<rs485_baud_rate>(baud),
                                               detail::in_range<data_format>(format))};
    }
};

} // namespace servobus::c630s
