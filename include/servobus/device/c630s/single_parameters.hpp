// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: any parameter by its row, until the power goes or for good, read back. A terminal's function is
// compared with those of the other terminals first. servobus/device/c630s.hpp includes it. Source: manual V24.111,
// chapters 6 and 7.
//
//     if (!servo.run(c630s::set<c630s::positioning_completed_threshold>{500})) return 1; // until the power goes
//     const command_status kept = servo.run(c630s::keep<c630s::di1_function>{c630s::input_function::home_switch});
//     if (kept.error() == errc::already_assigned)
//         std::printf("the register %04Xh has it\n", unsigned{servo.conflicting_terminal()});
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/setting_commands.hpp>
#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

using servobus::commands::keep, servobus::commands::set;

namespace detail {
template <const auto& R>
inline constexpr effect effect_of =
    servobus::row_type<R>::words == 2 ? effect::pair_set : effect::parameter_set;

/// `set` and `keep` refuse what the facade sets itself, and what acts immediately.
template <const auto& R> constexpr void check_settable() {
    static_assert(std::is_same_v<typename row_type<R>::device, device>,
                  "this register belongs to another device");
    static_assert(!has(R.flags, flag::communication),
                  "a setting of the line is no parameter: change_address and change_line write it");
    static_assert(has(R.flags, flag::saved_on_write) && !has(R.flags, flag::trigger),
                  "a command of the drive writes this register: enable, fault_reset, home, restart, ...");
    static_assert(!has(R.flags, flag::motion) && !commands::is_one_of<R, jog_speed>,
                  "a target is no parameter: velocity, torque, jog and step_size set it");
    constexpr bool is_mode_or_source =
        commands::is_one_of<R, mode_of_operation, main_speed_source, auxiliary_speed_source,
                            speed_command_selection, main_torque_source, torque_command_selection,
                            position_command_source, position_segment_mode, speed_segment_mode,
                            positioning_completed_condition>;
    static_assert(!is_mode_or_source,
                  "a mode and its sources are set by enable_in{} and its kin, at each enable");
    static_assert(R.address >> 8 != 0x17 && R.address >> 8 < 0x30 &&
                      !commands::is_one_of<R, virtual_inputs_enable, virtual_outputs_enable,
                                           virtual_inputs_at_power_on, power_on_functions_1_to_16>,
                  "the virtual terminals are arranged by set_up{}");
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
    check_settable<R>();
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

/// Sets a parameter until the power goes: `run(set<positioning_completed_threshold>{500})`. One that is taken only
/// while the servo is off is refused otherwise; one that counts from the next power-on does not compile: `keep` it.
///
/// A terminal's function, such as `di1_function`, is first compared with those of the other terminals: no two
/// inputs, wired or virtual, and no two wired outputs may have one (Er.130; sections 6.4.1 and 6.4.2).
/// Error: `already_assigned` if another terminal has it; nothing is written then, and
/// `drive::conflicting_terminal()` is the address of the register that holds it. Give that terminal another
/// function first, or none.
template <const auto& R>
constexpr prepared_command prepare(const set<R>& wanted, const cached_settings& cached) {
    static_assert(!has(R.flags, flag::after_power_cycle),
                  "this register counts from the next power-on: keep it");
    constexpr bool is_at_rest = has(R.flags, flag::when_stopped);
    const errc state = is_at_rest ? detail::needs_servo_off(cached) : detail::needs_init_done(cached);
    prepared_command o = detail::put<R>(routines::set_one, routines::set_two, wanted.value, state, cached);
    o.then = detail::effect_of<R>;
    return detail::look_for_rivals(o, R.address, false);
}

/// Sets a parameter for good, with the servo off: P0C-13 = 1, write, read back, P0C-13 = 0. It wears the
/// EEPROM by three writes or so: for set-up. Where it counts from the next power-on, the state is
/// `needs_power_cycle`. A terminal's function is compared with the others as `set` does it, so that the
/// restart does not end in Er.130:
///
///     command_status got = servo.run(keep<di1_function>{input_function::home_switch});
///     if (got.error() == errc::already_assigned) ... // servo.conflicting_terminal() == "P03-14"_p: DI7
///
/// Error: `already_assigned`.
template <const auto& R>
constexpr prepared_command prepare(const keep<R>& wanted, const cached_settings& cached) {
    constexpr bool is_later = has(R.flags, flag::after_power_cycle);
    const routine one = is_later ? routine{routines::keep_one_for_later} : routine{routines::keep_one};
    const routine two = is_later ? routine{routines::keep_two_for_later} : routine{routines::keep_two};
    prepared_command o = detail::put<R>(one, two, wanted.value, detail::needs_servo_off(cached), cached);
    o.then = is_later ? effect::needs_power_cycle : detail::effect_of<R>;
    return detail::look_for_rivals(o, R.address, true);
}

} // namespace servobus::c630s
