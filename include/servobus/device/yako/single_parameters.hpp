// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: any parameter by its row, microsteps and direction, collision homing, the gains of the
// current loop. What is set is read back. servobus/device/yako.hpp includes it. Source: manual V2.6.0, sections 4.3 and
// 5.1, appendices 2 and 3, which do not state when a parameter may be written: the rules here are on the safe side.
//
//     if (!axis.run(init{}) || !axis.run(disable{})) return 1;
//     if (!axis.run(yako::set_microsteps{2000}) || !axis.run(init{})) return 1; // positions count anew
//     if (!axis.run(yako::set<yako::closed_loop::max_current>{3 * ampere})) return 1; // the motor's rated current
//     if (!axis.run(yako::save{})) return 1;
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/setting_commands.hpp>
#include <servobus/device/yako/prepared_command.hpp>

namespace servobus::yako {

using servobus::commands::keep, servobus::commands::set;

namespace routines {
template <const auto& R>
inline constexpr step set_row[] = {same_drive, may_act, steps::write_arguments<R>(),
                                   steps::expect_arguments<R>()};
inline constexpr step set_microsteps[] = {same_drive, may_act, steps::write_arguments<microstep_resolution>(),
                                          steps::expect_arguments<microstep_resolution>()};
inline constexpr step set_direction[] = {same_drive, may_act, steps::write_arguments<motion_direction>(),
                                         steps::expect_arguments<motion_direction>()};
/// Section 4.3, methods -1 to -4.
inline constexpr step set_collision_homing[] = {
    same_drive, may_act, steps::write_arguments<cl::collision_threshold, cl::collision_current>(),
    steps::expect_arguments<cl::collision_threshold, cl::collision_current>()};
/// In one frame: no gain acts beside an old one.
inline constexpr step set_current_loop[] = {
    same_drive, may_act,
    steps::write_arguments<current_loop_kp_multiplier, current_loop_kp, current_loop_ki, current_loop_kc>(),
    steps::expect_arguments<current_loop_kp_multiplier, current_loop_kp, current_loop_ki, current_loop_kc>()};
} // namespace routines

namespace detail {
/// True for the addresses `first` to `last`.
constexpr bool is_between(std::uint16_t address, unsigned first, unsigned last) {
    return address >= first && address <= last;
}

/// Each row that `set` does not take has a command of its own. Both variants have these rows at the same addresses.
template <const auto& R> constexpr void check_settable() {
    constexpr std::uint16_t at = R.address;
    static_assert(std::is_base_of_v<device, typename row_type<R>::device>,
                  "this register belongs to another device");
    static_assert(
        !has(R.flags, flag::communication),
        "a setting of the line is no parameter: set_word_order, set_node_address, set_baud_rate and "
        "set_serial_format write it");
    static_assert(!has(R.flags, flag::trigger) && at != homing_offset_mode.address && at != 0x0031 &&
                      at != home_offset.address,
                  "a command of the drive writes this register: enable, move_by, home, save, ...");
    static_assert(!has(R.flags, flag::motion), "a target is no parameter: move_by and move_to set it");
    static_assert(at != microstep_resolution.address, "the microsteps are set by set_microsteps{}");
    static_assert(at != motion_direction.address, "the direction is set by set_direction{}");
    static_assert(at != over_travel_stop_mode.address,
                  "the stop at a limit is set by set_over_travel_stop{}");
    static_assert(at != 0x0018 && !is_between(at, 0x0037, 0x003A),
                  "the software limits are set by limit_travel and unlimit_travel");
    static_assert(at != 0x001A, "the worth of a count of speed is set by set_speed_resolution{}");
    static_assert(!is_between(at, 0x001D, 0x001F), "a jog is set by velocity{}");
    static_assert(!is_between(at, 0x0020, 0x0023), "the profile of moves is set by set_profile{}");
    static_assert(!is_between(at, 0x0032, 0x0034), "the speeds of homing are set by set_homing_profile{}");
    static_assert(!is_between(at, 0x0040, 0x004A), "inputs are set by set_input{} and set_input_polarity{}");
    static_assert(!is_between(at, 0x004B, 0x004F),
                  "outputs are set by set_output{}, set_output_polarity{} and set_outputs{}");
    static_assert(at != io_positioning.address, "a move that an input starts is set by set_input_move{}");
    static_assert(at != pv_trigger_mode.address, "what starts a speed segment is set by set_pv_trigger{}");
    static_assert(!is_between(at, 0x0060, 0x00BF), "a segment is set by set_position_segment{}");
    static_assert(!is_between(at, 0x00C0, 0x00EF), "a segment is set by set_speed_segment{}");
}
/// True for algorithm and encoder, 0100h and 0101h: the motor must be free.
constexpr bool needs_free_motor(std::uint16_t address) { return is_between(address, 0x0100, 0x0101); }
} // namespace detail

/// Takes the rows from 0100h on, 003Bh and 003Ch; all else has a command of its own. The control algorithm and the
/// encoder's resolution (0100h, 0101h) are set while the motor is free and stands (`wrong_state`, `busy`), currents,
/// filters and gains in each state after `init`.
template <const auto& R>
constexpr prepared_command prepare(const set<R>& wanted, const cached_settings& cached) {
    detail::check_settable<R>();
    constexpr requirement needs = detail::needs_free_motor(R.address)
                                      ? requirement::standing | requirement::released
                                      : requirement::nothing;
    return detail::set_word(routines::set_row<R>, static_cast<std::uint16_t>(wanted.value.bits() & 0xFFFF),
                            wanted.value.error(), cached, needs);
}
template <const auto& R> constexpr prepared_command prepare(const keep<R>&, const cached_settings&) {
    static_assert(row_type<R>::words == 0,
                  "this drive keeps all its parameters together: set this one, then save{}");
    return {.steps = no_steps};
}

/// Sets the pulses of a turn, 0011h, 400..51200; while the motor is free and stands. **Each position is another number
/// then**: the state is `needs_init`, and `init` takes the drive over with the new number; home the axis, or declare
/// its position. What segments and limits hold stays a number of pulses. A drive that moves an axis compares the number
/// with its geometry at `init` (`unexpected_value`).
struct set_microsteps {
    register_value<microstep_resolution> pulses;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o =
            detail::set_word(routines::set_microsteps, static_cast<std::uint16_t>(pulses.bits() & 0xFFFF),
                             pulses.error(), cached, requirement::standing | requirement::released);
        o.then = effect::forgotten;
        return o;
    }
};

/// Sets the direction of positive positions and speeds, 0010h; while the motor is free and stands. **Each
/// position is another place then**: as after `set_microsteps`.
struct set_direction {
    direction to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::set_word(routines::set_direction, static_cast<std::uint16_t>(to),
                                              detail::in_range<motion_direction>(to), cached,
                                              requirement::standing | requirement::released);
        o.then = effect::forgotten;
        return o;
    }
};

/// Sets the gains of the current loop in one frame, 010Eh..0111h; the manual states neither ranges nor defaults: note
/// what the drive holds first. In each state after `init`.
struct set_current_loop {
    register_value<current_loop_kp_multiplier> kp_multiplier;
    register_value<current_loop_kp> kp;
    register_value<current_loop_ki> ki;
    register_value<current_loop_kc> kc;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto low = [](u32 bits) { return static_cast<std::uint16_t>(bits & 0xFFFF); };
        return {.steps = routines::set_current_loop,
                .arguments = {low(kp_multiplier.bits()), low(kp.bits()), low(ki.bits()), low(kc.bits())},
                .refusal = detail::first_error(detail::needs_init_done(cached), kp_multiplier.error(),
                                               kp.error(), ki.error(), kc.error())};
    }
};

namespace closed_loop {
/// Sets when homing against a stop (methods -1 to -4) takes it for reached: 003Bh, 50..4000 of following error, with at
/// most this share of the rated current, 003Ch, 20..100 %. In one frame, at standstill. Section 4.3.
struct set_collision_homing {
    using device = closed_loop::device;
    register_value<collision_threshold> threshold;
    register_value<collision_current> most;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::set_collision_homing,
                .arguments = {static_cast<std::uint16_t>(threshold.bits() & 0xFFFF),
                              static_cast<std::uint16_t>(most.bits() & 0xFFFF)},
                .needs = requirement::standing,
                .refusal =
                    detail::first_error(detail::needs_init_done(cached), threshold.error(), most.error())};
    }
};
} // namespace closed_loop

} // namespace servobus::yako
