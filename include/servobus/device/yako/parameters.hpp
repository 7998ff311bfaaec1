// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: the commands that set them up: profiles, segments, terminals, limits, word
// order, speed resolution, communication, parameters saved and restored. What is set is read back.
// servobus/device/yako.hpp includes it. Source: manual V2.6.0, chapters 2 and 5, sections 4.3 to 4.5.
//
//     if (!axis.run(init{}) || !axis.run(disable{})) return 1; // `set_input` needs a free shaft
//     if (!axis.run(yako::set_input{yako::input_terminal::x0, yako::input_function::home})) return 1;
//     if (!axis.run(yako::set_homing_profile{200 * r_per_min, 20 * r_per_min})) return 1;
//     if (!axis.run(limit_travel{-500 * pulse, 40'000 * pulse})) return 1; // once it is homed
//     if (!axis.run(yako::save{})) return 1;                                     // in the EEPROM
#pragma once

#include <concepts>
#include <cstdint>

#include <servobus/device/yako/commands.hpp>

namespace servobus::yako {

/// The profile of moves that name none, 0020h..0023h. It holds for what begins afterwards, stops included.
struct set_profile {
    motion_profile to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o{.steps = routines::set_profile,
                           .then = effect::profile_set,
                           .refusal = detail::needs_init_done(cached)};
        const errc stored = to.is_stored() ? errc::bad_argument : errc::ok;
        o.refusal = detail::first_error(o.refusal, stored, to.put(o.arguments, cached));
        return o;
    }
};

/// How home is looked for, 0032h..0034h: fast to the switch, 5..3000 r/min, slowly back to its edge, 5..300
/// r/min; ramps 30..2000 ms.
struct set_homing_profile {
    speed fast;
    speed slow;
    time ramp{100};
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto to = detail::count_of<closed_loop::homing_fast_speed>(fast, cached);
        const auto back = detail::count_of<closed_loop::homing_slow_speed>(slow, cached);
        const auto ramps = detail::count_of<homing_ramp_time>(ramp);
        return {.steps = routines::set_homing_profile,
                .arguments = {to.word, back.word, ramps.word},
                .then = effect::homing_profile_set,
                .refusal =
                    detail::first_error(detail::needs_init_done(cached), to.error, back.error, ramps.error)};
    }
};

namespace detail {
// Not constexpr on purpose: a constant that calls it does not compile, and the error names the rule.
inline void segments_are_numbered_1_to_16() {}
} // namespace detail

/// The number of a segment, 1..16. Another constant does not compile; a run-time value enters by name,
/// `checked(n)`, and is refused then (`bad_argument`).
class segment {
  public:
    template <std::integral N> consteval segment(N constant) { // NOLINT: implicit, a number
        servobus::check_count<N>();
        if (constant < 1 || constant > 16) detail::segments_are_numbered_1_to_16();
        index_ = static_cast<std::uint8_t>(constant - 1);
    }
    template <std::integral N> constexpr segment(checked_value<N> n) { // NOLINT: implicit, `checked(n)`
        servobus::check_count<N>();
        if (n.value < 1 || n.value > 16) {
            error_ = errc::bad_argument;
        } else {
            index_ = static_cast<std::uint8_t>(n.value - 1);
        }
    }

    constexpr std::uint8_t index() const { return index_; }
    constexpr errc error() const { return error_; }

  private:
    std::uint8_t index_ = 0;
    errc error_ = errc::ok;
};

/// One of the moves that inputs choose (PIN0..PIN3) and start (PT): nothing else starts them, and their
/// speeds stay counts when the speed resolution changes. Number 16 takes the place of the marker by which a
/// restart shows (`restart_visible()`). Section 4.4.
struct set_position_segment {
    segment number;
    distance target;
    speed top;
    time acceleration{100};
    time deceleration{100};
    positioning from = positioning::relative;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const word_pair words = detail::words_of(target, cached);
        const auto count = detail::count_of<at<closed_loop::position_segment_speeds, 0>>(top, cached);
        const auto rise =
            detail::count_of<at<closed_loop::position_segment_acceleration_times, 0>>(acceleration);
        const auto fall =
            detail::count_of<at<closed_loop::position_segment_deceleration_times, 0>>(deceleration);
        return {.steps = routines::set_position_segment,
                .arguments = {words.first, words.second, count.word, rise.word, fall.word,
                              static_cast<std::uint16_t>(from)},
                .shift = static_cast<std::uint16_t>(number.index() * position_segment_targets.stride),
                .then = number.index() == 15 ? effect::segment_set : effect::none,
                .refusal = detail::first_error(detail::needs_init_done(cached), number.error(),
                                               detail::in_range(target), count.error, rise.error, fall.error,
                                               detail::in_range<at<position_segment_positionings, 0>>(from))};
    }
};

/// One of the speeds that inputs choose and start (PV), -3000..3000 r/min. Section 4.5.
struct set_speed_segment {
    segment number;
    speed target;
    time acceleration{100};
    time deceleration{100};
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto count = detail::count_of<at<closed_loop::speed_segment_speeds, 0>>(target, cached);
        const auto rise =
            detail::count_of<at<closed_loop::speed_segment_acceleration_times, 0>>(acceleration);
        const auto fall =
            detail::count_of<at<closed_loop::speed_segment_deceleration_times, 0>>(deceleration);
        return {.steps = routines::set_speed_segment,
                .arguments = {count.word, rise.word, fall.word},
                .shift =
                    static_cast<std::uint16_t>(number.index() * closed_loop::speed_segment_speeds.stride),
                .refusal = detail::first_error(detail::needs_init_done(cached), number.error(), count.error,
                                               rise.error, fall.error)};
    }
};

/// What of the PV input starts a speed segment, 0051h; `rising_edge` where both kinds of segments are used.
struct set_pv_trigger {
    pv_trigger by;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_pv_trigger, static_cast<std::uint16_t>(by),
                                detail::in_range<pv_trigger_mode>(by), cached);
    }
};

/// The move that an input with the function `position_move` starts, and by which it ends a jog: interrupt
/// positioning. Command `velocity` afterwards, with ramps of its own. Profile and target are one frame, whether it
/// is relative another: where it is cut short between them, the input starts the old move, the new one, or a
/// way of zero at a speed of zero, which is taken to be no motion; never a target of the wrong kind.
/// Section 5.4.
struct set_input_move {
    distance target;
    motion_profile by;
    positioning from = positioning::relative;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_absolute = from == positioning::absolute;
        prepared_command o = detail::move<positioning::relative>(target, by, while_moving::interrupt, cached);
        const errc homed = is_absolute ? detail::needs_homed(cached) : errc::ok;
        const errc stored = by.is_stored() ? errc::bad_argument : errc::ok;
        o.refusal = detail::first_error(o.refusal, stored, detail::in_range<io_positioning>(from), homed);
        o.steps =
            is_absolute ? routine{routines::absolute_input_move} : routine{routines::relative_input_move};
        o.then = effect::profile_set;
        o.has_profile = false;
        o.has_target = false;
        o.needs = is_absolute ? requirement::homed : requirement::nothing;
        return o;
    }
};

enum class input_terminal : std::uint8_t { x0, x1, x2, x3, x4, x5, x6 }; ///< closed loop: up to X3
enum class output_terminal : std::uint8_t { y0, y1, y2 };                ///< closed loop: up to Y1

/// What an input does, 0041h..0047h; while the motor is released, so that an input that is active starts
/// nothing. Section 5.2.
struct set_input {
    input_terminal terminal;
    input_function as;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const input_terminal last = cached.is_closed_loop ? input_terminal::x3 : input_terminal::x6;
        const errc wrong = terminal > last ? errc::bad_argument : detail::in_range<x0_function>(as);
        prepared_command o = detail::set_word(routines::set_input, static_cast<std::uint16_t>(as), wrong,
                                              cached, requirement::standing | requirement::released);
        o.shift = static_cast<std::uint16_t>(terminal);
        return o;
    }
};

/// What an output shows, 004Ch..004Eh. Section 5.2.
struct set_output {
    output_terminal terminal;
    output_function as;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const output_terminal last = cached.is_closed_loop ? output_terminal::y1 : output_terminal::y2;
        const bool has_meaning = as <= output_function::brake || as >= output_function::user_0;
        const errc wrong = terminal > last ? errc::bad_argument
                           : !has_meaning  ? errc::out_of_range
                                           : detail::in_range<y0_function>(as);
        prepared_command o =
            detail::set_word(routines::set_output, static_cast<std::uint16_t>(as), wrong, cached);
        o.shift = static_cast<std::uint16_t>(terminal);
        return o;
    }
};

/// Which inputs are normally closed, 0040h; while the motor is released.
template <class Device, class Inputs> struct basic_set_input_polarity {
    using device = Device;
    Inputs normally_closed;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_input_polarity, normally_closed.to_word(), errc::ok, cached,
                                requirement::standing | requirement::released);
    }
};
/// Which outputs are normally closed, 004Bh.
template <class Device, class Outputs> struct basic_set_output_polarity {
    using device = Device;
    Outputs normally_closed;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_output_polarity, normally_closed.to_word(), errc::ok, cached);
    }
};
/// The outputs that the program has for itself, 004Fh [errata A28].
template <class Device, class Outputs> struct basic_set_outputs {
    using device = Device;
    Outputs active;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_outputs, active.to_word(), errc::ok, cached);
    }
};
namespace closed_loop {
using set_input_polarity = basic_set_input_polarity<device, inputs>;
using set_output_polarity = basic_set_output_polarity<device, outputs>;
using set_outputs = basic_set_outputs<device, outputs>;
} // namespace closed_loop
namespace open_loop {
using set_input_polarity = basic_set_input_polarity<device, inputs>;
using set_output_polarity = basic_set_output_polarity<device, outputs>;
using set_outputs = basic_set_outputs<device, outputs>;
} // namespace open_loop

/// The software limits, 0037h..003Ah, and 0018h, at standstill: they act once the axis has been homed. What
/// the motor does beyond them is 0017h (`set_over_travel_stop`), from the factory to coast. A drive that has
/// lost them is found out by the next command, as a restart is. Section 5.3.
using servobus::limit_travel;
using travel_bounds = limit_travel<distance>;
constexpr prepared_command prepare(const travel_bounds& wanted, const cached_settings& cached) {
    const word_pair up = detail::words_of(wanted.highest, cached);
    const word_pair down = detail::words_of(wanted.lowest, cached);
    const errc wrong = wanted.highest > wanted.lowest ? errc::ok : errc::bad_argument;
    return {.steps = routines::limit_travel,
            .arguments = {up.first, up.second, down.first, down.second},
            .then = effect::limited,
            .needs = requirement::standing,
            .refusal =
                detail::first_error(detail::needs_init_done(cached), wrong, detail::in_range(wanted.highest),
                                    detail::in_range(wanted.lowest))};
}
/// Switches the software limits off.
struct unlimit_travel {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::unlimit_travel,
                .then = effect::unlimited,
                .refusal = detail::needs_init_done(cached)};
    }
};
/// What the drive does at a limit that is overrun, 0017h.
struct set_over_travel_stop {
    over_travel_stop by;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_over_travel_stop, static_cast<std::uint16_t>(by),
                                detail::in_range<over_travel_stop_mode>(by), cached);
    }
};

/// The order of the words of 32-bit values, 0019h, at standstill. If the answer is lost, the word order is
/// unknown and no such value is sent before `init` has read it. Section 5.5.
struct set_word_order {
    word_order_setting to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o =
            detail::set_word(routines::set_word_order, static_cast<std::uint16_t>(to),
                             detail::in_range<pair_word_order>(to), cached, requirement::standing);
        o.then = effect::word_order_set;
        return o;
    }
};

/// What a count of a speed is worth, 001Ah, closed loop, at standstill. Which registers it rescales is not
/// stated [errata A37]; this takes it as all that count r/min. So a drive that already has 0.1 r/min at
/// `init` is ordered no speed (`wrong_state`) until the program has said by this command that it wants one or
/// the other; and the speeds that the drive holds, of profiles, homing and segments, must be set again after
/// it: taken the wrong way the motor turns ten times too fast. Try it slowly. Errors: `bad_argument` on open
/// loop.
struct set_speed_resolution {
    speed_count to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const errc wrong = detail::first_error(detail::needs_closed_loop(cached),
                                               detail::in_range<closed_loop::speed_resolution>(to));
        prepared_command o = detail::set_word(routines::set_speed_resolution, static_cast<std::uint16_t>(to),
                                              wrong, cached, requirement::standing);
        o.then = effect::resolution_set;
        return o;
    }
};

/// Keeps all parameters in EEPROM, at standstill; whether those marked RW are among them is not stated
/// [errata A53]. Errors: `busy`; `not_executed` if the motor is found moving afterwards, since the drive may
/// acknowledge a save that it does not carry out; `exception` if it refuses one [errata A56]. Section 5.1.
struct save {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::save,
                .then = effect::kept,
                .needs = requirement::standing,
                .refusal = detail::needs_init_done(cached)};
    }
};

using servobus::sole_drive_on_the_line;

/// Restores the factory's parameters, at standstill, as `save` otherwise. Initialise again afterwards:
/// address, baud rate, word order and scale may have changed. An address that changes at once ends it
/// `unknown`.
struct factory_reset {
    constexpr explicit factory_reset(sole_drive_on_the_line) {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::factory_reset,
                .then = effect::reset,
                .needs = requirement::standing,
                .refusal = detail::needs_init_done(cached)};
    }
};

/// The address that the drive has while all of its address switches are off, 0013h. When it takes effect is
/// not stated: make a drive object with the new address, and `init` it. Section 2.2.
struct set_node_address {
    constexpr set_node_address(std::uint8_t to, sole_drive_on_the_line) : to_{to} {}
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_address = to_ >= device::facts.lowest_address && to_ <= device::facts.highest_address;
        prepared_command o =
            detail::set_word(routines::set_node_address, to_, is_address ? errc::ok : errc::out_of_range,
                             cached, requirement::standing);
        o.then = effect::forgotten;
        return o;
    }
    constexpr std::uint8_t address() const { return to_; }

  private:
    std::uint8_t to_;
};

/// The baud rate from the next power-on, 0014h; save it too. Section 2.3.
struct set_baud_rate {
    baud_rate to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_baud_rate, static_cast<std::uint16_t>(to),
                                detail::in_range<rs485_baud_rate>(to), cached, requirement::standing);
    }
};
/// Parity and stop bits from the next power-on, 0015h; save them too. Section 2.3.
struct set_serial_format {
    serial_format to;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::set_word(routines::set_serial_format, static_cast<std::uint16_t>(to),
                                detail::in_range<rs485_format>(to), cached, requirement::standing);
    }
};

} // namespace servobus::yako
