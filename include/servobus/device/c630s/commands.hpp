// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the commands that operate it, in a control engineer's words: take over, set up, enable,
// stop, reset, speed and torque, read feedback. Those that move to positions are in moves.hpp.
// servobus/device/c630s.hpp includes it. Source: manual V24.111, chapters 5 to 9.
//
//     if (!servo.run(init{}) || !servo.run(c630s::enable_in{c630s::control_mode::torque})) return 1;
//     if (!servo.run(c630s::torque{50 * percent})) return 1; // of the rated torque, also if the line is lost
//     if (!servo.run(halt{})) return 1;               // the target is 0, the motor stays energised
//     if (!servo.run(disable{})) return 1;
#pragma once

#include <cstdint>

#include <servobus/control/motion_commands.hpp>
#include <servobus/device/c630s/prepared_command.hpp>

namespace servobus::c630s {

/// Takes a drive over, whatever an earlier program did with it: writes zero targets and servo-off, waits until
/// the motor is at standstill (up to 60 s), switches off the writes to the EEPROM (P0C-13 = 0), reads the
/// settings that commands need, and compares the virtual terminals with those of `set_up` (`needs_set_up` if
/// they differ). Nothing moves. A wired servo-on input keeps its function until `set_up`. The writes before
/// P0C-13 is 0 go into the EEPROM if it was 1: up to five after each restart of the drive.
///
/// A drive whose response delay (P0C-25) is longer than the node's response limit needs a node with a longer
/// one. After `init` P0C-25 is added to that limit; on a bus up to the limit of its plan.
constexpr prepared_command prepare(init, const cached_settings&) {
    return {.steps = routines::init, .then = effect::initialised};
}

/// Assigns the virtual terminals as terminals.hpp lists them, in the EEPROM, with the servo off. Wired inputs
/// lose the functions that the virtual ones get, since one function on two inputs is Er.130: servo-on, the
/// choice and start of segments, steps, jogging. The same functions are not active at power-on any more (P03-00,
/// P03-01, P0C-10). A wired servo-on input does nothing after that.
///
/// Every other wired input keeps its function: limit switches, home switch, emergency stop, and the alarm
/// reset (FunIN.2), which resets faults only while servo-on is off. A wired homing start (FunIN.32, FunIN.38)
/// keeps its terminal and has no effect: P05-30 becomes 0, since a homing at power-on or by an input is a motion
/// that the program did not command, and a position that an input sets makes the next absolute move end
/// elsewhere. Use `home` and `set_home`.
///
/// Registers that are right already are not written; less than 100 are. If one was written the state is
/// `needs_power_cycle`: switch the drive off and on, then `init`.
struct set_up {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::look_at_block,
                .then = effect::examined,
                .refusal = detail::needs_servo_off(cached),
                .shift = detail::as_word(detail::set_up_blocks[0] - routines::first_of_blocks)};
    }
};

namespace detail {
constexpr prepared_command enable_by(routine steps, control_mode mode, const cached_settings& cached,
                                     segment_mode positions, segment_mode speeds, std::uint16_t choice,
                                     std::uint16_t inputs) {
    return {.steps = steps,
            .arguments = {cached.inputs, as_word(positions), as_word(speeds), choice,
                          static_cast<std::uint16_t>(inputs | terminal::marker), word_order_value(cached)},
            .then = effect::enabled,
            .mode = mode,
            .refusal = first_error(needs_disabled(cached), in_range<position_segment_mode>(positions),
                                   in_range<speed_segment_mode>(speeds))};
}
} // namespace detail

/// Writes zero targets and reads them back; then energises the motor in `mode`, confirmed by the released brake
/// (BK), since the manual has no output for "energised". Only from `disabled`, at standstill, without a fault,
/// with the drive ready. First it switches off what the factory settings would start: cyclic segments run only
/// if they are requested here. P05-30 becomes 0, whatever it was, as after `set_up`: no wired input
/// starts a homing or sets the home position. In position control P05-20 becomes "deviation and command", so that
/// a wired COIN output turns on only once the command has ended too: from the factory (0) it turns on whenever the
/// deviation is small. Mode, sources and P05-20 are set without the EEPROM. Sections 6.1 to 6.3.
///
/// Errors: `wrong_state`, `needs_init` (it was restarted), `busy`, `faulted`, `not_reached` (it was switched
/// off again), `bad_argument` for the modes that wired inputs switch: which level means what is not
/// documented.
struct enable_in {
    control_mode mode;
    position_source positions = position_source::segments;
    segment_mode run_segments = segment_mode::by_input; ///< P11-00

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto from = static_cast<std::uint16_t>(positions);
        routine steps = no_steps;
        switch (mode) {
        case control_mode::speed: steps = routines::enable_speed; break;
        case control_mode::torque: steps = routines::enable_torque; break;
        case control_mode::position: steps = routines::enable_position; break;
        default: return detail::refused(errc::bad_argument);
        }
        prepared_command o = detail::enable_by(steps, mode, cached, run_segments, segment_mode::by_input,
                                               from, terminal::servo_on);
        o.refusal = detail::first_error(o.refusal, detail::in_range<position_command_source>(positions));
        return o;
    }
};

/// In speed mode; `enable_in` names another.
constexpr prepared_command prepare(enable, const cached_settings& cached) {
    return enable_in{control_mode::speed}.prepare(cached);
}

/// Energises the motor in speed mode with the segments of P12 as its command: **it runs at once**, with
/// segment `from` where inputs choose it (P12-00 = 2), else from the first to segment `last`. It is stopped
/// by `disable` or `quick_stop`; `halt` is refused, since the segments change only while the servo is off.
/// Section 6.2.3.
struct run_speed_segments {
    segment_mode run = segment_mode::by_input;
    segment_number from = 1;
    segment_number last = 16;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool by_input = run == segment_mode::by_input;
        const std::uint16_t chosen = by_input ? terminal::for_segment(from.index()) : std::uint16_t{0};
        prepared_command o =
            detail::enable_by(routines::enable_speed_segments, control_mode::speed, cached,
                              segment_mode::by_input, run, static_cast<std::uint16_t>(last.number()),
                              static_cast<std::uint16_t>(terminal::servo_on | chosen));
        o.refusal = detail::first_error(o.refusal, from.error(), last.error());
        o.then = effect::runs_speed_segments;
        return o;
    }
};

namespace detail {
/// P31-00 with the servo off.
constexpr std::uint16_t inputs_when_off(const cached_settings& cached) {
    return cached.is_marked() ? terminal::marker : std::uint16_t{0};
}
/// Which stop acts before the marker has been read: where zero targets stop nothing, an emergency stop.
constexpr routine servo_off_by(const cached_settings& cached) {
    if (!cached.is_marked()) return routines::disable;
    if (cached.state != drive_state::enabled) return routines::disable_marked;
    if (cached.mode == control_mode::position || cached.runs_speed_segments)
        return routines::disable_marked_at_once;
    return cached.mode == control_mode::torque ? routine{routines::disable_marked_torque}
                                               : routine{routines::disable_marked};
}
constexpr prepared_command stop_by_all_means(const cached_settings& cached) {
    return {.steps = cached.is_marked() ? routine{routines::stop_all_marked} : routine{routines::stop_all},
            .arguments = {0, inputs_when_off(cached)},
            .then = effect::stopped,
            .stop = stop_priority::disable};
}
constexpr prepared_command stop_sparing() {
    return {.steps = routines::stop_all_sparing, .then = effect::stopped, .stop = stop_priority::disable};
}
} // namespace detail

/// Servo off; waits until the motor is at standstill (up to 60 s) and its power is off (P02-10). The shaft is free
/// then; with factory settings the motor coasts (P02-05). It may replace a quick stop that is waiting. After `init` its
/// first frame stops the motor by zero targets, or by P0D-05 in position control and where segments of speeds run. The
/// second reads P31-00, whose marker the third, servo off, would otherwise set again after a restart.
constexpr prepared_command prepare(disable, const cached_settings& cached) {
    return {.steps = detail::servo_off_by(cached),
            .arguments = {0, detail::inputs_when_off(cached)},
            .then = effect::disabled,
            .stop = stop_priority::disable};
}

/// Writes zero targets and ends a jog; the motor stays energised. Position control and speed segments have no
/// halt: use `quick_stop` or `disable`. If nothing is known of the drive it is stopped by every means, and the
/// servo is switched off.
constexpr prepared_command prepare(halt, const cached_settings& cached) {
    prepared_command o{.steps = routines::halt_speed, .then = effect::halted, .stop = stop_priority::halt};
    if (!cached.is_initialised()) {
        o.steps = routines::stop_all;
        o.then = effect::stopped;
    }
    if (cached.state != drive_state::enabled) return o;
    if (cached.mode == control_mode::position || cached.runs_speed_segments)
        return detail::refused(errc::wrong_state);
    if (cached.mode == control_mode::torque) o.steps = routines::halt_torque;
    if (cached.is_jogging()) {
        o.steps = routines::halt_jog;
        o.arguments = {cached.inputs, terminal::servo_on | terminal::marker};
        o.then = effect::jog_halted;
    }
    return o;
}

/// Emergency stop, P0D-05: zero speed as fast as the drive can, then zero targets. Whether the drive then holds
/// its position, as with FunIN.34, is not stated. `disable` and `enable` must follow before the next motion.
/// While segments run one after the other the servo is switched off after it, since they might continue. A drive
/// that is known to be disabled is stopped as by `disable`.
constexpr prepared_command prepare(quick_stop, const cached_settings& cached) {
    if (cached.state == drive_state::disabled) return prepare(disable{}, cached);
    prepared_command o{
        .steps = routines::quick_stop, .then = effect::quick_stopped, .stop = stop_priority::quick_stop};
    if (!cached.runs_by_itself() && cached.is_initialised()) return o;
    o.steps = cached.is_marked() ? routine{routines::quick_stop_of_marked_segments}
                                 : routine{routines::quick_stop_of_segments};
    o.arguments = {0, detail::inputs_when_off(cached)};
    o.then = effect::disabled;
    return o;
}

/// Servo off, then P0D-01, in this sequence (section 5.2.4). The servo stays off. Eighteen faults are reset only by
/// switching the power off (alarms.hpp). Errors: `faulted` if a fault remains, or, before the set-up, a warning;
/// `wrong_state` in the state `needs_power_cycle`.
constexpr prepared_command prepare(fault_reset, const cached_settings& cached) {
    prepared_command o = prepare(disable{}, cached);
    o.then = effect::disabled_for_reset;
    o.stop = stop_priority::no_stop;
    o.refusal =
        detail::first_error(detail::needs_init_done(cached),
                            cached.state == drive_state::needs_power_cycle ? errc::wrong_state : errc::ok);
    return o;
}

using servobus::hold, servobus::runs_on_without_line, servobus::velocity;

/// `velocity{speed}` and `hold{speed, runs_on_without_line{}}` in whole r/min.
using motor_velocity = velocity<speed>;
using held_velocity = hold<speed, runs_on_without_line>;

/// A speed in any unit of a turning motor. A constant that is no whole number of r/min does not compile.
template <unit U, class Rep>
[[gnu::always_inline]] constexpr motor_velocity in_units_of(const velocity<quantity<U, Rep>>& wanted,
                                                            const cached_settings*) {
    return {commands::exactly<speed>(wanted.target)};
}
template <unit U, class Rep>
[[gnu::always_inline]] constexpr held_velocity
in_units_of(const hold<quantity<U, Rep>, runs_on_without_line>& wanted, const cached_settings*) {
    return {commands::exactly<speed>(wanted.target), {}};
}
template <unit U, class Rep>
constexpr held_velocity in_units_of(const hold<quantity<U, Rep>>&, const cached_settings*) {
    static_assert(sizeof(Rep) == 0,
                  "this motor turns on when the line is lost: hold{speed, runs_on_without_line{}}");
    return {};
}

/// Speed mode: the target, P06-03, whole r/min; the ramps are `ramps`. Beyond P06-07 to P06-09 it is refused.
/// **The drive has no watchdog**: it keeps its speed when the line is lost.
constexpr prepared_command prepare(const motor_velocity& wanted, const cached_settings& cached) {
    const auto c = detail::count_in<target_speed>(wanted.target);
    return {.steps = routines::velocity,
            .arguments = {cached.inputs, detail::as_word(c.count)},
            .then = effect::driven,
            .refusal = detail::first_error(detail::needs_mode(cached, control_mode::speed), c.error,
                                           cached.is_jogging() ? errc::wrong_state : errc::ok,
                                           detail::within_top_speeds(c.count, cached))};
}

/// Speed mode: turns at a speed for as long as the program repeats the command; `halt` ends it. As `velocity`, but for
/// what ends it:
/// - The program steps and stops repeating: the motor stops after the facade's command timeout. A blocking call counts
///   as a repetition, as for every command timeout.
/// - The program stops stepping, or the line is lost: **the motor turns on**, since the drive has no watchdog. So the
///   command does not compile without `runs_on_without_line{}`.
/// - The response is lost: the target is read back; where that fails too the state is `needs_init` (G21).
/// - The drive restarts: its motor has no power, and the state is `needs_init`.
/// Another speed, also of another sign, holds from then on, by `ramps`. Errors: as `velocity`; `bad_argument` without a
/// command timeout: state one for the facade, whose default is none.
constexpr prepared_command prepare(const held_velocity& wanted, const cached_settings& cached) {
    return prepare(motor_velocity{wanted.target}, cached);
}

/// Torque mode: the target, P07-03, in 0.1 % of the rated torque, within P07-09 and P07-10. What bounds the
/// speed is `torque_speed_limits`; the factory's are 3000 r/min. No watchdog here either.
struct torque {
    torque_share target;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto c = detail::count_in<target_torque>(target);
        const bool is_within = c.count <= cached.positive_torque && -c.count <= cached.negative_torque;
        return {.steps = routines::torque,
                .arguments = {cached.inputs, detail::as_word(c.count)},
                .then = effect::driven,
                .refusal = detail::first_error(detail::needs_mode(cached, control_mode::torque), c.error,
                                               is_within ? errc::ok : errc::out_of_range)};
    }
};

/// Speed mode: runs at P06-04 by the jog inputs until `halt`, negative in reverse. The manual ties FunIN.18
/// and 19 to "the given command", not expressly to P06-04; the target P06-03 is zero meanwhile. Whether its
/// limits P06-07 to P06-09 bound a jog is not stated: beyond them it is refused, as `velocity` is. **It is
/// endless, and the drive has no watchdog.**
struct jog {
    speed at;

    constexpr prepared_command prepare(const cached_settings& cached) const {
        const bool is_reverse = at.count() < 0;
        const auto c = detail::count_in<jog_speed>(is_reverse ? -at : at);
        const std::uint16_t way = is_reverse ? terminal::jog_reverse : terminal::jog_forward;
        return {.steps = routines::jog,
                .arguments = {cached.inputs,
                              static_cast<std::uint16_t>(terminal::servo_on | terminal::marker | way),
                              detail::as_word(c.count)},
                .then = effect::jogged,
                .refusal =
                    detail::first_error(detail::needs_mode(cached, control_mode::speed), c.error,
                                        detail::within_top_speeds(is_reverse ? -c.count : c.count, cached))};
    }
};

/// Reads the status in one frame.
struct read_status {
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::status, .then = effect::seen, .refusal = detail::needs_init_done(cached)};
    }
};

/// Reads status, speed, torque, position, deviation and the present alarm in five short frames;
/// `drive::feedback` has them.
constexpr prepared_command prepare(read_feedback, const cached_settings& cached) {
    return {.steps = routines::feedback, .then = effect::seen, .refusal = detail::needs_word_order(cached)};
}

/// By which a take-over knows it: the plan shows no motion.
void moves_or_energises(const enable_in*);

} // namespace servobus::c630s
