// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the commands of position control: segments that the drive moves by itself, steps, homing;
// and the choice among speed segments. servobus/device/c630s.hpp includes it. Source: manual V24.111,
// sections 6.1.3, 6.2.3, 7.5, 7.14 and 7.15.
//
//     if (!servo.run(c630s::segment{3, 20'000 * reference_unit, 600 * r_per_min})) return 1;
//     if (!servo.run(c630s::enable_in{c630s::control_mode::position})) return 1;
//     const c630s::arrival there = servo.run(c630s::start_segment{3}, wait_reached{});
//     if (there.how != arrival_state::reached) std::printf("%ld units short\n", long{there.missing.count()});
#pragma once

#include <cstdint>

#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

/// Sets a position segment in one frame and reads it back; at any time, and without the EEPROM. `way` is a
/// place where `position_segments` says so. Times count as milliseconds: a drive that was set to seconds
/// refuses it (`wrong_state`).
struct segment {
    segment_number number;
    distance way;  ///< +-1073741824 reference units
    speed at;      ///< 1..6000 r/min
    time ramp{10}; ///< 0..65535 ms
    time wait{10}; ///< after it, 0..10000 ms

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto w = detail::count_in<servobus::at<position_segment_displacements, 0>>(way);
        const auto v = detail::count_in<servobus::at<position_segment_speeds, 0>>(at);
        const std::int64_t up = ramp.count();
        const std::int64_t rest = wait.count();
        const word_pair words = split_words(static_cast<u32>(way.count()), cached.word_order);
        return {.steps = routines::segment,
                .arguments = {words.first, words.second, detail::as_word(v.count), detail::as_word(up),
                              detail::as_word(rest), detail::word_order_value(cached)},
                .refusal = detail::first_error(
                    detail::needs_word_order(cached), number.error(), w.error, v.error,
                    detail::in_range<servobus::at<position_segment_acceleration_times, 0>>(up),
                    detail::in_range<servobus::at<position_segment_wait_times, 0>>(rest)),
                .shift = static_cast<std::uint16_t>(number.index() * position_segment_displacements.stride)};
    }
};

/// How the position segments are run, P11-01 to P11-05, with the servo off; in which order is `enable_in`'s.
struct position_segments {
    displacement_type type = displacement_type::relative;
    segment_number last = 1;
    segment_remainder remainder = segment_remainder::restart; ///< what a stop left undone does not go on
    std::uint16_t first = 0; ///< in the sequential mode, 0..16; what 0 means is not stated

    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::position_segments,
                .arguments = {static_cast<std::uint16_t>(last.number()), detail::as_word(remainder),
                              detail::as_word(position_time_unit::milliseconds), detail::as_word(type),
                              first},
                .refusal = detail::first_error(detail::needs_servo_off(cached), last.error(),
                                               detail::in_range<position_segment_remainder>(remainder),
                                               detail::in_range<position_segment_type>(type),
                                               detail::in_range<first_position_segment>(first))};
    }
};

namespace detail {
constexpr prepared_command start_by(routine steps, const cached_settings& cached, position_source source,
                                    std::uint16_t chosen, std::uint16_t trigger) {
    const auto held = static_cast<std::uint16_t>(terminal::servo_on | terminal::marker | chosen);
    return {.steps = steps,
            .arguments = {cached.inputs, held, static_cast<std::uint16_t>(held | trigger), as_word(source)},
            .then = effect::moved,
            .refusal = needs_positions_from(cached, source)};
}
} // namespace detail

/// Position mode, `segment_mode::by_input`: chooses a segment and starts it. Refused while the motor moves (`busy`),
/// and towards a limit switch that is active (`wrong_state`, Er.950 and Er.952): nothing is sent then but reads.
/// The start is sent once: if it gets no response the positions are compared (`drive::motion()`),
/// nothing is sent again. A segment that was never set holds the factory's 10000 reference units.
struct start_segment {
    segment_number number;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::start_by(routines::start, cached, position_source::segments,
                                              terminal::for_segment(number.index()), terminal::segment_start);
        o.refusal = detail::first_error(o.refusal, number.error(),
                                        cached.runs_by_itself() ? errc::wrong_state : errc::ok);
        o.shift = static_cast<std::uint16_t>(number.index() * position_segment_displacements.stride);
        return o;
    }
};

/// Position mode, the other segment modes: starts the run from its first segment. As `start_segment`, but where
/// it ends is not known to this program: `wait_reached` is refused, and `wait_standstill` has the drive's own
/// word for it. It counts as a motion without an end, which a command timeout stops.
struct start_segments {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::start_by(routines::start_run, cached, position_source::segments, 0,
                                              terminal::segment_start);
        o.then = effect::runs_segments;
        o.refusal = detail::first_error(o.refusal, cached.runs_by_itself() ? errc::ok : errc::wrong_state);
        return o;
    }
};

/// The step that `make_step` makes, P05-05, +-9999 reference units; with the servo off.
struct step_size {
    distance way;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto w = detail::count_in<position_step>(way);
        return {.steps = routines::step_size,
                .arguments = {detail::as_word(w.count)},
                .refusal = detail::first_error(detail::needs_servo_off(cached), w.error)};
    }
};

/// Position mode with `position_source::step`: one step of P05-05, by the edge of FunIN.20. As
/// `start_segment`.
struct make_step {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::start_by(routines::start_step, cached, position_source::step, 0, terminal::step_start);
    }
};

/// Waits for the end of the last move: until the drive calls it completed (COIN) or presses at its torque limit,
/// and the motor is at standstill; then the position is read. `drive::arrival()` says how the move has ended. Errors:
/// `stopped_short`; `faulted`; `not_reached` after the limit; `wrong_state` if no move with a known end was
/// started.
constexpr prepared_command prepare(const wait_reached& wanted, const cached_settings& cached) {
    return {.steps = routines::wait_reached,
            .then = effect::arrived,
            .refusal = detail::needs_init_done(cached),
            .limit = wanted.limit};
}

/// Waits until the motor is at standstill; in position control as `wait_reached`, also for a run of several segments,
/// whose end is the drive's own word (COIN). Errors: `not_reached`; those of `wait_reached`.
constexpr prepared_command prepare(const wait_standstill& wanted, const cached_settings& cached) {
    const bool is_moved = cached.state == drive_state::enabled && cached.mode == control_mode::position;
    return {.steps = is_moved ? routine{routines::wait_reached} : routine{routines::stand_still},
            .then = is_moved ? effect::stood : effect::none,
            .refusal = detail::needs_init_done(cached),
            .limit = wanted.limit};
}

/// How `home` searches, P05-31 to P05-35, with the servo off. A home switch and limits are wired inputs.
struct homing_by {
    homing_mode mode;
    speed fast{100};                   ///< 0..3000 r/min
    speed slow{10};                    ///< 0..1000 r/min
    time ramp{1000};                   ///< 0..1000 ms
    std::uint16_t time_limit = 10'000; ///< in the unit of P05-61, presumably ms

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto f = detail::count_in<homing_high_speed>(fast);
        const auto s = detail::count_in<homing_low_speed>(slow);
        const auto r = detail::count_in<homing_acceleration_time>(ramp);
        return {.steps = routines::homing_by,
                .arguments = {detail::as_word(mode), detail::as_word(f.count), detail::as_word(s.count),
                              detail::as_word(r.count), time_limit},
                .refusal =
                    detail::first_error(detail::needs_servo_off(cached),
                                        detail::in_range<homing_method>(mode), f.error, s.error, r.error)};
    }
};

namespace detail {
constexpr prepared_command home_by(homing how, time within, const cached_settings& cached) {
    const std::int32_t ms = within.count();
    const bool is_wrong = ms <= 0 || ms > 2'000'000;
    return {.steps = routines::look_before_home,
            .arguments = {cached.inputs, as_word(how)},
            .then = effect::home_looked_at,
            .refusal = first_error(needs_mode(cached, control_mode::position),
                                   is_wrong ? errc::out_of_range : errc::ok),
            .limit = is_wrong ? duration{} : milliseconds(static_cast<std::uint32_t>(ms))};
}
/// The outputs were read. A drive may leave that of an earlier homing as it is: then it is no sign of this one.
constexpr void begin_homing(prepared_command& c, slice<const std::uint16_t> words) {
    const bool is_electrical = c.arguments[1] == as_word(homing::start_electrical);
    const std::uint16_t sign = is_electrical ? status_flags::electrical_bit : status_flags::homed_bit;
    const bool is_old = (words[0] & sign) != 0;
    c.then = effect::homed;
    if (is_electrical)
        c.steps = is_old ? routine{routines::home_electrically_again} : routine{routines::home_electrically};
    else
        c.steps = is_old ? routine{routines::home_again} : routine{routines::home};
}
} // namespace detail

/// Position mode: searches home now (P05-30 = 4) and waits until the drive says so, at most `within`. If it
/// does not, the servo is switched off before this returns. Where the drive still says so of an earlier
/// homing, that must end within 2 s of the start, or nothing can be told of this one: `not_reached`. Errors:
/// `not_reached`, as Er.601 also ends.
struct home {
    time within;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::home_by(c630s::homing::start, within, cached);
    }
};

/// The same to the electrical home, P05-30 = 5. Where it has been there already, a way too short to be seen
/// ends as `not_reached`.
struct home_electrically {
    time within;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::home_by(c630s::homing::start_electrical, within, cached);
    }
};

/// The present position is home (P05-30 = 6), at standstill. How the drive confirms it is not stated.
struct set_home {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::set_home,
                .arguments = {cached.inputs},
                .then = effect::home_set,
                .refusal = detail::needs_init_done(cached)};
    }
};

/// While `run_speed_segments` runs with inputs: goes over to another segment. `wrong_state` in another mode.
struct select_speed_segment {
    segment_number number;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const errc state = detail::needs_enabled(cached);
        const auto next = static_cast<std::uint16_t>(terminal::servo_on | terminal::marker |
                                                     terminal::for_segment(number.index()));
        return {.steps = routines::change_inputs,
                .arguments = {cached.inputs, next},
                .then = effect::segment_selected,
                .refusal = detail::first_error(
                    state, cached.chooses_speed_segments() ? errc::ok : errc::wrong_state, number.error())};
    }
};

/// By which a take-over knows what moves the motor although its plan reads the drive first.
void moves_or_energises(const start_segment*);
void moves_or_energises(const start_segments*);
void moves_or_energises(const make_step*);
void moves_or_energises(const home*);
void moves_or_energises(const home_electrically*);
void moves_or_energises(const select_speed_segment*);

} // namespace servobus::c630s
