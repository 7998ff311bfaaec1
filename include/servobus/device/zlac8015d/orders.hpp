// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: what a control engineer orders, with physical units. An order is checked against what is
// believed of the drive before anything is sent, and becomes a routine with its arguments.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/device/zlac8015d/routines.hpp>

namespace servobus::zlac8015d {

/// Speeds: every resolution that the drive has, 1 .. 1/10 r/min, is a whole number of these. `30 * r_per_min`
/// and `125 * part<10>(r_per_min)` convert to it exactly.
using speed = quantity<units::r_per_min / 2520, std::int32_t>;
using current = quantity<units::milliampere, std::int32_t>;
using time = quantity<units::millisecond, std::int32_t>;
using distance = quantity<units::pulse, std::int32_t>;
using current_slope = quantity<units::milliampere_per_second, std::int32_t>;

enum class drive_state : std::uint8_t {
    needs_init,    ///< nothing is believed of the drive; only `init`, stops and raw access are possible
    disabled,      ///< the shafts are free, or held as 2007h, 200Ch and the brakes say
    enabled,       ///< in the mode that was ordered, targets obeyed
    quick_stopped, ///< enable must follow before motion
};

/// What the program believes of the drive. Void after an unknown outcome, silence or a restart.
struct beliefs {
    drive_state state = drive_state::needs_init;
    operating_mode mode = operating_mode::undefined;
    synchronisation starts = synchronisation::asynchronous;
    std::uint16_t resolution = 1;   ///< 2022h: a commanded count is 1/resolution r/min
    std::uint16_t max_speed = 0;    ///< 2008h, r/min
    std::uint16_t host_timeout = 0; ///< 2000h, ms; 0: none
};

/// What becomes of the beliefs once the routine is done.
enum class effect : std::uint8_t {
    none,
    initialised,
    enabled,
    disabled,
    quick_stopped,
    moved,
    motion, ///< a target was set: counts as a command of the application
    timeout_set,
    resolution_set,
    forgotten,
    seen, ///< feedback was read
};

/// An order made ready: steps and arguments, or the reason why it is refused here.
struct order {
    routine steps{};
    std::array<std::uint16_t, 4> arguments{};
    effect then = effect::none;
    operating_mode mode = operating_mode::undefined;
    errc refusal = errc::ok;
    bool is_stop = false; ///< goes out in any state and cuts another routine short
};

namespace detail {
constexpr order refused(errc why) { return {.refusal = why}; }

/// A speed in counts of 2088h/2089h, or the error: `out_of_range` above the drive's own limit 2008h, beyond
/// which it raises a fault [errata B5]; `inexact` if it is no whole number of counts.
struct speed_count {
    std::uint16_t word = 0;
    errc error = errc::ok;
};
constexpr speed_count count_of(speed wanted, const beliefs& known) {
    constexpr std::int32_t per_r_per_min = 2520;
    const std::int32_t parts = wanted.count();
    const std::int32_t limit = known.max_speed * per_r_per_min;
    if (parts > limit || parts < -limit) return {0, errc::out_of_range};
    const std::int32_t scaled = parts * known.resolution;
    const std::int32_t counts = scaled / per_r_per_min;
    if (counts * per_r_per_min != scaled) return {0, errc::inexact};
    if (counts < left_target_speed.limits.low || counts > left_target_speed.limits.high)
        return {0, errc::out_of_range};
    return {static_cast<std::uint16_t>(counts), errc::ok};
}

template <const auto& R, unit U> constexpr servobus::detail::counted count_in(quantity<U, std::int32_t> q) {
    servobus::detail::counted c = servobus::detail::count_of<R>(q);
    if (c.error == errc::ok && !R.limits.contains(c.count)) c.error = errc::out_of_range;
    return c;
}
constexpr errc first_error(errc a, errc b) { return a != errc::ok ? a : b; }
constexpr std::uint16_t word(std::int64_t count) { return static_cast<std::uint16_t>(count & 0xFFFF); }

constexpr errc needs(const beliefs& known, operating_mode mode) {
    if (known.state == drive_state::needs_init) return errc::needs_init;
    return known.state == drive_state::enabled && known.mode == mode ? errc::ok : errc::wrong_state;
}
constexpr errc needs_init_done(const beliefs& known) {
    return known.state == drive_state::needs_init ? errc::needs_init : errc::ok;
}
constexpr errc needs_disabled(const beliefs& known) {
    if (known.state == drive_state::needs_init) return errc::needs_init;
    return known.state == drive_state::disabled ? errc::ok : errc::wrong_state;
}

/// Both wheels take one value of a row and its twin: 10h with a pair of equal rows.
template <const auto& R, unit U>
constexpr order set_pair(routine steps, quantity<U, std::int32_t> left, quantity<U, std::int32_t> right,
                         const beliefs& known) {
    const auto l = count_in<R>(left);
    const auto r = count_in<R>(right);
    return {.steps = steps,
            .arguments = {word(l.count), word(r.count)},
            .refusal = first_error(needs_init_done(known), first_error(l.error, r.error))};
}
} // namespace detail

/// Takes a drive over, whatever a program before this one did: stops it, waits until it stands (up to 34 s),
/// reads what must be known. Nothing moves.
struct init {
    constexpr order plan(const beliefs&) const {
        return {.steps = routines::init, .then = effect::initialised};
    }
};

/// Zero targets, read back; then energises both motors in `mode`. Only at standstill and without a fault.
/// Section 3.1..3.3 of the manual.
struct enable {
    operating_mode mode = operating_mode::velocity;
    synchronisation starts = synchronisation::synchronous; ///< position modes: both wheels a start, or one

    constexpr order plan(const beliefs& known) const {
        if (known.state == drive_state::needs_init) return detail::refused(errc::needs_init);
        order o{.arguments = {known.resolution, known.host_timeout, static_cast<std::uint16_t>(starts)},
                .then = effect::enabled,
                .mode = mode};
        switch (mode) {
        case operating_mode::velocity: o.steps = routines::enable_velocity; return o;
        case operating_mode::torque: o.steps = routines::enable_torque; return o;
        case operating_mode::relative_position: o.steps = routines::enable_relative_position; return o;
        case operating_mode::absolute_position: o.steps = routines::enable_absolute_position; return o;
        case operating_mode::undefined: break;
        }
        return detail::refused(errc::bad_argument);
    }
};

/// Ends the operation (07h) and waits until both wheels stand. They may roll afterwards.
struct disable {
    constexpr order plan(const beliefs&) const {
        return {.steps = routines::disable, .then = effect::disabled, .is_stop = true};
    }
};

/// Targets to zero, both motors stay energised. In the position modes there is no such command: use
/// `quick_stop` or `disable`.
struct halt {
    constexpr order plan(const beliefs& known) const {
        order o{.steps = routines::halt_speed, .is_stop = true};
        if (known.state == drive_state::needs_init)
            return o; // zero speeds: the only halt that is always safe
        if (known.mode == operating_mode::torque) o.steps = routines::halt_torque;
        const bool is_position = known.mode == operating_mode::relative_position ||
                                 known.mode == operating_mode::absolute_position;
        if (is_position && known.state == drive_state::enabled) return detail::refused(errc::wrong_state);
        return o;
    }
};

/// Stops both wheels by 2011h and holds them there until the next enable. Section 3.4.
struct quick_stop {
    constexpr order plan(const beliefs& known) const {
        order o{.steps = routines::quick_stop, .then = effect::quick_stopped, .is_stop = true};
        if (known.state == drive_state::needs_init) o.steps = routines::quick_stop_after_silence;
        return o;
    }
};

/// Clears the faults, at standstill; the drive stays disabled. Section 3.5.
/// Errors: `faulted` if a fault is still there.
struct fault_reset {
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::fault_reset,
                .then = effect::disabled,
                .refusal = detail::needs_init_done(known)};
    }
};

/// Velocity mode: both wheels in one frame. Errors: `out_of_range`, `inexact`, `wrong_state`, `needs_init`.
struct velocity {
    speed left;
    speed right;

    constexpr order plan(const beliefs& known) const {
        const auto l = detail::count_of(left, known);
        const auto r = detail::count_of(right, known);
        return {.steps = routines::velocity,
                .arguments = {l.word, r.word},
                .then = effect::motion,
                .refusal = detail::first_error(detail::needs(known, operating_mode::velocity),
                                               detail::first_error(l.error, r.error))};
    }
};

/// Velocity mode: the left wheel alone; the right one keeps its target.
struct left_velocity {
    speed left;
    constexpr order plan(const beliefs& known) const {
        const auto l = detail::count_of(left, known);
        return {.steps = routines::left_velocity,
                .arguments = {l.word},
                .then = effect::motion,
                .refusal = detail::first_error(detail::needs(known, operating_mode::velocity), l.error)};
    }
};

/// Velocity mode: the right wheel alone; the left one keeps its target.
struct right_velocity {
    speed right;
    constexpr order plan(const beliefs& known) const {
        const auto r = detail::count_of(right, known);
        return {.steps = routines::right_velocity,
                .arguments = {r.word},
                .then = effect::motion,
                .refusal = detail::first_error(detail::needs(known, operating_mode::velocity), r.error)};
    }
};

/// Velocity mode: as `velocity`, but a pair too fast is slowed down together, so that the curve is kept, and
/// each speed is cut to a whole number of counts.
struct clamped_velocity {
    speed left;
    speed right;

    constexpr velocity within(const beliefs& known) const {
        const std::int32_t limit =
            (known.max_speed * known.resolution > 3000 ? 3000 / known.resolution : known.max_speed) * 2520;
        const std::int32_t fastest = magnitude(left) > magnitude(right) ? magnitude(left) : magnitude(right);
        return {fit(left, fastest, limit, known), fit(right, fastest, limit, known)};
    }
    constexpr order plan(const beliefs& known) const { return within(known).plan(known); }

  private:
    static constexpr std::int32_t magnitude(speed s) {
        constexpr std::int32_t most = 0x7FFF'FFFF;
        return s.count() >= 0 ? s.count() : s.count() < -most ? most : -s.count();
    }
    // limit / fastest in steps of 1/4096, rounded down: 32 bits are enough, and no speed is raised.
    static constexpr speed fit(speed s, std::int32_t fastest, std::int32_t limit, const beliefs& known) {
        std::int32_t parts = magnitude(s);
        if (fastest > limit) {
            const std::int32_t share = parts / (fastest / 4096 + 1);
            parts = limit / 4096 * share;
        }
        const std::int32_t one_count = 2520 / known.resolution;
        parts = parts / one_count * one_count;
        return speed{s.count() < 0 ? -parts : parts};
    }
};

/// Torque mode: both wheels in one frame, mA.
struct torque {
    current left;
    current right;
    constexpr order plan(const beliefs& known) const {
        order o = detail::set_pair<left_target_torque>(routines::torque, left, right, known);
        o.refusal = detail::first_error(detail::needs(known, operating_mode::torque), o.refusal);
        o.then = effect::motion;
        return o;
    }
};

/// Torque mode: one wheel; the other keeps its target.
struct left_torque {
    current left;
    constexpr order plan(const beliefs& known) const {
        order o = torque{left, {}}.plan(known);
        o.steps = routines::left_torque;
        return o;
    }
};
struct right_torque {
    current right;
    constexpr order plan(const beliefs& known) const {
        order o = torque{right, {}}.plan(known);
        o.steps = routines::right_torque;
        return o;
    }
};

namespace detail {
constexpr order move(routine steps, operating_mode mode, synchronisation starts, const beliefs& known,
                     std::array<std::int32_t, 2> pulses, std::int32_t most) {
    order o{.steps = steps, .then = effect::moved, .refusal = needs(known, mode)};
    if (o.refusal == errc::ok && known.starts != starts) o.refusal = errc::wrong_state;
    std::size_t used = 0;
    for (const std::int32_t p : pulses) {
        if (p > most || p < -most) o.refusal = first_error(o.refusal, errc::out_of_range);
        const word_pair words = split_words(static_cast<u32>(p), device::facts.order);
        o.arguments[used++] = words.first;
        o.arguments[used++] = words.second;
    }
    return o;
}
inline constexpr std::int32_t longest_way = 0x7FFF'FFFF;
inline constexpr std::int32_t farthest_place = 0x3FFF'FFFF;
} // namespace detail

/// Relative position mode, synchronous: both wheels start together. Refused while a wheel moves. The move is
/// ordered once: after an unanswered start the positions are compared (`drive::motion()`), nothing is sent
/// again. Section 3.2.
struct move_by {
    distance left;
    distance right;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_both, operating_mode::relative_position,
                            synchronisation::synchronous, known, {left.count(), right.count()},
                            detail::longest_way);
    }
};
/// Relative position mode, asynchronous: one wheel.
struct move_left_by {
    distance left;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_left, operating_mode::relative_position,
                            synchronisation::asynchronous, known, {left.count(), 0}, detail::longest_way);
    }
};
struct move_right_by {
    distance right;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_right, operating_mode::relative_position,
                            synchronisation::asynchronous, known, {right.count(), 0}, detail::longest_way);
    }
};
/// Absolute position mode, synchronous: places within +-0x3FFFFFFF.
struct move_to {
    distance left;
    distance right;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_both, operating_mode::absolute_position,
                            synchronisation::synchronous, known, {left.count(), right.count()},
                            detail::farthest_place);
    }
};
/// Absolute position mode, asynchronous: one wheel.
struct move_left_to {
    distance left;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_left, operating_mode::absolute_position,
                            synchronisation::asynchronous, known, {left.count(), 0}, detail::farthest_place);
    }
};
struct move_right_to {
    distance right;
    constexpr order plan(const beliefs& known) const {
        return detail::move(routines::move_right, operating_mode::absolute_position,
                            synchronisation::asynchronous, known, {right.count(), 0}, detail::farthest_place);
    }
};

/// Acceleration and deceleration times of both wheels, 0..32767 ms.
struct ramps {
    time acceleration;
    time deceleration;
    constexpr order plan(const beliefs& known) const {
        order o =
            detail::set_pair<left_acceleration_time>(routines::ramps, acceleration, deceleration, known);
        o.arguments = {o.arguments[0], o.arguments[0], o.arguments[1], o.arguments[1]};
        return o;
    }
};

/// Deceleration time of the quick stop, both wheels, 0..32767 ms.
struct quick_stop_ramp {
    time deceleration;
    constexpr order plan(const beliefs& known) const {
        return detail::set_pair<left_quick_stop_time>(routines::quick_stop_ramp, deceleration, deceleration,
                                                      known);
    }
};

/// What a quick stop does, 2011h.
struct quick_stop_by {
    quick_stop_option option;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::quick_stop_by,
                .arguments = {static_cast<std::uint16_t>(option)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// Slope of the torque targets, both wheels, mA/s.
struct torque_slope {
    current_slope slope;
    constexpr order plan(const beliefs& known) const {
        return detail::set_pair<left_torque_slope>(routines::torque_slope, slope, slope, known);
    }
};

/// Top speeds of the position modes, whole r/min, 1..1000.
struct position_speed {
    speed left;
    speed right;
    constexpr order plan(const beliefs& known) const {
        return detail::set_pair<left_max_speed>(routines::position_speed, left, right, known);
    }
};

/// Opens or closes the brakes, 201Ah and 201Bh. Section 3.6.
struct brakes {
    brake left;
    brake right;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::brakes,
                .arguments = {static_cast<std::uint16_t>(left), static_cast<std::uint16_t>(right)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// What the shafts do after the emergency-stop input, 2021h. Section 3.7.
struct on_input_stop {
    input_stop_action action;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::input_stop,
                .arguments = {static_cast<std::uint16_t>(action)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// Parking mode, 200Ch.
struct park {
    off_on parking;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::parking,
                .arguments = {static_cast<std::uint16_t>(parking)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// Sets the position feedback of these wheels to zero, 2005h; at standstill.
struct clear_position {
    wheels of = wheels::both;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::clear_feedback,
                .arguments = {static_cast<std::uint16_t>(of)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// Makes the present place the zero of the absolute mode, 2006h; at standstill.
struct clear_absolute_zero {
    wheels of = wheels::both;
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::clear_absolute,
                .arguments = {static_cast<std::uint16_t>(of)},
                .refusal = detail::needs_init_done(known)};
    }
};

/// Keeps all parameters marked RW/S in EEPROM, 2010h; at standstill, disabled.
struct save {
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::save, .refusal = detail::needs_disabled(known)};
    }
};

/// Said by name: no other drive on this line is live, so that a node address that falls back to 1 meets none.
struct sole_drive_on_the_line {};

/// Restores the factory's parameters, 2009h; at standstill, disabled. Initialise again afterwards: address,
/// baud rate and scales may have changed.
struct factory_reset {
    constexpr explicit factory_reset(sole_drive_on_the_line) {}
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::factory_reset,
                .then = effect::forgotten,
                .refusal = detail::needs_disabled(known)};
    }
};

/// The drive's own watchdog, 2000h: it stops the motors after this long without a request; 1..32767 ms. 0 is
/// refused: its meaning is not documented.
struct watchdog {
    time limit;
    constexpr order plan(const beliefs& known) const {
        const auto ms = detail::count_in<host_timeout>(limit);
        const errc zero = ms.count == 0 ? errc::out_of_range : ms.error;
        return {.steps = routines::set_host_timeout,
                .arguments = {detail::word(ms.count)},
                .then = effect::timeout_set,
                .refusal = detail::first_error(detail::needs_init_done(known), zero)};
    }
};

/// Resolution of commanded speeds, 2022h: 1/n r/min, n = 1..10; at standstill, disabled. Speeds that are
/// ordered through the drive follow it by themselves.
struct resolution {
    std::uint16_t n;
    constexpr order plan(const beliefs& known) const {
        const errc wrong = speed_resolution.limits.contains(n) ? errc::ok : errc::out_of_range;
        return {.steps = routines::set_resolution,
                .arguments = {n},
                .then = effect::resolution_set,
                .refusal = detail::first_error(detail::needs_disabled(known), wrong)};
    }
};

/// Waits until both wheels stand, at most 60 s. Errors: `not_reached`.
struct stand {
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::stand, .refusal = detail::needs_init_done(known)};
    }
};

/// Reads state, faults, positions and speeds in one frame; `drive::seen()` has them.
struct read_feedback {
    constexpr order plan(const beliefs& known) const {
        return {.steps = routines::feedback, .then = effect::seen, .refusal = detail::needs_init_done(known)};
    }
};

} // namespace servobus::zlac8015d
