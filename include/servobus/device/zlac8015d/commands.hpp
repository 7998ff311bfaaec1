// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the commands that operate it, in a control engineer's words: take over, enable, stop,
// move, read feedback. servobus/device/zlac8015d.hpp includes it. Source: RS485 manual V1.07, chapter 3.
//
//     constexpr auto mode = zlac8015d::operating_mode::relative_position;
//     if (!wheels.run(init{}) || !wheels.run(zlac8015d::enable_in{mode})) return 1;
//     if (!wheels.run(move_by{4096 * pulse, -4096 * pulse})) return 1; // both start together
//     if (!wheels.run(wait_standstill{})) return 1;
//     if (!wheels.run(disable{})) return 1;
#pragma once

#include <cstdint>

#include <servobus/control/motion_commands.hpp>
#include <servobus/device/zlac8015d/prepared_command.hpp>

namespace servobus::zlac8015d {

/// Takes a drive over, whatever a program before this one did: stops it, waits until it stands (up to 34 s),
/// reads what must be known. Nothing moves.
constexpr prepared_command prepare(init, const cached_settings&) {
    return {.steps = routines::init, .then = effect::initialised};
}

namespace detail {
// Not constexpr on purpose: a constant that calls it does not compile, and the error names the rule.
inline void this_drive_is_not_enabled_in_this_operating_mode() {}

constexpr routine enable_routine(operating_mode mode) {
    switch (mode) {
    case operating_mode::velocity: return routines::enable_velocity;
    case operating_mode::torque: return routines::enable_torque;
    case operating_mode::relative_position: return routines::enable_relative_position;
    case operating_mode::absolute_position: return routines::enable_absolute_position;
    case operating_mode::undefined: break;
    }
    return no_steps;
}
} // namespace detail

/// An operating mode in which the drive is enabled. A constant of another one does not compile, and links the
/// routine of its mode only; a mode of the running program enters by `checked(mode)`, and the command is
/// refused (`bad_argument`) if there is no such mode.
class enable_mode {
  public:
    consteval enable_mode(operating_mode constant) // NOLINT: implicit, `enable_in{operating_mode::torque}`
        : steps_{detail::enable_routine(constant)}, mode_{constant} {
        if (steps_.empty()) detail::this_drive_is_not_enabled_in_this_operating_mode();
    }
    constexpr enable_mode(checked_value<operating_mode> m) // NOLINT: implicit, `enable_in{checked(mode)}`
        : steps_{detail::enable_routine(m.value)}, mode_{m.value} {}

    constexpr routine steps() const { return steps_.after(0); } // a copy would link memcpy
    constexpr operating_mode mode() const { return mode_; }
    constexpr errc error() const { return steps_.empty() ? errc::bad_argument : errc::ok; }

  private:
    routine steps_;
    operating_mode mode_;
};

/// Zero targets, read back; then energises both motors in `mode`. Only at standstill and without a fault.
/// Section 3.1..3.3 of the manual.
struct enable_in {
    enable_mode mode;
    synchronisation starts = synchronisation::synchronous; ///< position modes: both wheels a start, or one

    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = mode.steps(),
                .arguments = {cached.resolution, cached.host_timeout, static_cast<std::uint16_t>(starts)},
                .then = effect::enabled,
                .mode = mode.mode(),
                .refusal = detail::first_error(detail::needs_power(cached), mode.error())};
    }
};

/// In velocity mode; `enable_in` names another.
constexpr prepared_command prepare(enable, const cached_settings& cached) {
    return enable_in{operating_mode::velocity}.prepare(cached);
}

/// Ends the operation (07h) and waits until both wheels stand. They may roll afterwards.
constexpr prepared_command prepare(disable, const cached_settings&) {
    return {.steps = routines::disable, .then = effect::disabled, .stop = stop_priority::disable};
}

namespace detail {
/// False if there is no such stop in the drive's mode.
constexpr bool plan_halt(prepared_command& o, const cached_settings& cached) {
    const bool is_enabled = cached.state == drive_state::enabled;
    if (is_enabled && cached.mode != operating_mode::velocity && cached.mode != operating_mode::torque)
        return false;
    o.steps = cached.state == drive_state::needs_init               ? routine{routines::stop_both}
              : is_enabled && cached.mode == operating_mode::torque ? routine{routines::halt_torque}
                                                                    : routine{routines::halt_speed};
    return true;
}
constexpr void plan_quick_stop(prepared_command& o, const cached_settings& cached) {
    const bool is_disabled =
        cached.state == drive_state::disabled || cached.state == drive_state::needs_power_cycle;
    o.then = is_disabled ? effect::disabled : effect::quick_stopped;
    o.steps = is_disabled                               ? routine{routines::disable}
              : cached.state == drive_state::needs_init ? routine{routines::quick_stop_after_silence}
                                                        : routine{routines::quick_stop};
}
} // namespace detail

/// Targets to zero, both motors stay energised. In the position modes there is no such command: use
/// `quick_stop` or `disable`. Where nothing is known of the drive it stops by every means and ends the
/// operation, as `init` does.
constexpr prepared_command prepare(halt, const cached_settings& cached) {
    prepared_command o{.steps = no_steps, .stop = stop_priority::halt};
    if (!detail::plan_halt(o, cached)) o.refusal = errc::wrong_state;
    return o;
}

/// Stops both wheels by 2011h and holds them there until the next enable. Section 3.4. A drive that is known
/// to be disabled has nothing to hold and is stopped as `disable` does.
constexpr prepared_command prepare(quick_stop, const cached_settings& cached) {
    prepared_command o{.steps = no_steps, .stop = stop_priority::quick_stop};
    detail::plan_quick_stop(o, cached);
    return o;
}

/// Clears the faults, at standstill; the drive stays disabled. Section 3.5.
/// Errors: `faulted` if a fault is still there.
constexpr prepared_command prepare(fault_reset, const cached_settings& cached) {
    return {
        .steps = routines::fault_reset, .then = effect::disabled, .refusal = detail::needs_init_done(cached)};
}

using servobus::hold, servobus::move_by, servobus::move_to, servobus::velocity;

/// `velocity{left, right}` in counts of 1/2520 r/min, which has every count of every resolution (2022h).
using wheel_velocities = velocity<speed, speed>;
using held_velocities = hold<speed, speed>;
using wheel_ways = move_by<distance, distance>;   ///< `move_by{left, right}`
using wheel_places = move_to<distance, distance>; ///< `move_to{left, right}`

/// Speeds in any unit of a turning motor. A constant that is no whole number of 1/2520 r/min does not compile.
template <unit U, class A, unit V, class B>
[[gnu::always_inline]] constexpr wheel_velocities
in_units_of(const velocity<quantity<U, A>, quantity<V, B>>& wanted, const cached_settings*) {
    return {commands::exactly<speed>(wanted.left), commands::exactly<speed>(wanted.right)};
}
template <unit U, class A, unit V, class B>
[[gnu::always_inline]] constexpr held_velocities
in_units_of(const hold<quantity<U, A>, quantity<V, B>>& wanted, const cached_settings*) {
    return {commands::exactly<speed>(wanted.left), commands::exactly<speed>(wanted.right)};
}

/// Velocity mode: both wheels in one frame. Errors: `out_of_range`, `inexact`, `wrong_state`, `needs_init`.
constexpr prepared_command prepare(const wheel_velocities& wanted, const cached_settings& cached) {
    const auto l = detail::count_of(wanted.left, cached);
    const auto r = detail::count_of(wanted.right, cached);
    return {.steps = routines::velocity,
            .arguments = {l.word, r.word},
            .then = effect::motion,
            .refusal = detail::first_error(detail::needs(cached, operating_mode::velocity),
                                           detail::first_error(l.error, r.error))};
}

/// Velocity mode: both wheels at a speed for as long as the program repeats the command; `halt` ends it. As `velocity`,
/// but something must stop the wheels when it is not repeated:
/// - The program steps and stops repeating: they stop after the facade's command timeout. A blocking call counts as a
///   repetition, as for every command timeout.
/// - The program stops stepping, or the line is lost: the drive's watchdog stops them (2000h; `watchdog`).
/// - The response is lost: the targets are read back; where that fails too the state is `needs_init` (G21).
/// - The drive restarts: its motors have no power, and the state is `needs_init`.
/// Another pair of speeds, also of other signs, holds from then on, by the drive's ramps. Errors: as `velocity`;
/// `bad_argument` without a command timeout (`no_command_timeout`), `wrong_state` if 2000h is 0.
constexpr prepared_command prepare(const held_velocities& wanted, const cached_settings& cached) {
    prepared_command o = prepare(wheel_velocities{wanted.left, wanted.right}, cached);
    o.refusal = detail::first_error(o.refusal, cached.host_timeout == 0 ? errc::wrong_state : errc::ok);
    return o;
}

/// Velocity mode: the left wheel alone; the right one keeps its target.
struct left_velocity {
    speed left;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto l = detail::count_of(left, cached);
        return {.steps = routines::left_velocity,
                .arguments = {l.word},
                .then = effect::motion,
                .refusal = detail::first_error(detail::needs(cached, operating_mode::velocity), l.error)};
    }
};

/// Velocity mode: the right wheel alone; the left one keeps its target.
struct right_velocity {
    speed right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        const auto r = detail::count_of(right, cached);
        return {.steps = routines::right_velocity,
                .arguments = {r.word},
                .then = effect::motion,
                .refusal = detail::first_error(detail::needs(cached, operating_mode::velocity), r.error)};
    }
};

/// Velocity mode: as `velocity`, but each speed becomes the nearest whole number of counts, halves away from
/// zero, and a pair too fast is slowed down together, so that the curve is kept.
struct clamped_velocity {
    speed left{};
    speed right{};

    constexpr clamped_velocity() = default;
    constexpr clamped_velocity(speed l, speed r) : left{l}, right{r} {} // not one of both

    constexpr wheel_velocities within(const cached_settings& cached) const {
        const std::uint32_t most = left_target_speed.limits.high;
        const std::uint32_t reached = std::uint32_t{cached.max_speed} * cached.resolution;
        const std::uint32_t limit = reached < most ? reached : most; // in counts
        const std::uint32_t one_count = 2520u / cached.resolution;
        const std::uint32_t fastest = longer(magnitude(left), magnitude(right));
        const auto fit = [&](speed s) {
            const std::uint32_t counts = fastest > limit * one_count
                                             ? share(magnitude(s), limit, fastest)
                                             : (magnitude(s) + one_count / 2) / one_count;
            const auto parts = static_cast<std::int32_t>(counts * one_count);
            return speed{s.count() < 0 ? -parts : parts};
        };
        return {fit(left), fit(right)};
    }
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return zlac8015d::prepare(within(cached), cached);
    }

  private:
    static constexpr std::uint32_t longer(std::uint32_t a, std::uint32_t b) { return a > b ? a : b; }
    static constexpr std::uint32_t magnitude(speed s) {
        const auto bits = static_cast<std::uint32_t>(s.count());
        return s.count() < 0 ? 0u - bits : bits;
    }
    // limit * part / whole to the nearest, bit by bit of `limit`: no 64-bit division, which is dear on a
    // small core. `part` is at most `whole`, and that at most 2^31.
    static constexpr std::uint32_t share(std::uint32_t part, std::uint32_t limit, std::uint32_t whole) {
        std::uint32_t counts = 0;
        std::uint32_t rest = 0; // below `whole`
        const auto add = [&](std::uint32_t more) {
            const bool carries = rest >= whole - more;
            rest = carries ? rest - (whole - more) : rest + more;
            counts += carries ? 1u : 0u;
        };
        for (std::uint32_t bit = 0x800; bit != 0; bit >>= 1) {
            counts *= 2;
            add(rest);
            if ((limit & bit) != 0) add(part);
        }
        return rest >= whole - rest ? counts + 1 : counts;
    }
};

/// Torque mode: both wheels in one frame, mA.
struct torque {
    current left;
    current right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = detail::set_pair<left_target_torque>(routines::torque, left, right, cached);
        o.refusal = detail::first_error(detail::needs(cached, operating_mode::torque), o.refusal);
        o.then = effect::motion;
        return o;
    }
};

/// Torque mode: one wheel; the other keeps its target.
struct left_torque {
    current left;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = torque{left, {}}.prepare(cached);
        o.steps = routines::left_torque;
        return o;
    }
};
/// As `left_torque`, of the right wheel.
struct right_torque {
    current right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = torque{right, {}}.prepare(cached);
        o.steps = routines::right_torque;
        return o;
    }
};

namespace detail {
constexpr prepared_command move(routine steps, operating_mode mode, synchronisation starts,
                                const cached_settings& cached, const std::int32_t (&pulses)[2],
                                std::int32_t most, wheels which = wheels::both) {
    prepared_command o{.steps = steps, .then = effect::moved, .which = which, .refusal = needs(cached, mode)};
    if (o.refusal == errc::ok && cached.starts != starts) o.refusal = errc::wrong_state;
    std::size_t used = 0;
    for (const std::int32_t p : pulses) {
        if (p > most || p < -most) o.refusal = first_error(o.refusal, errc::out_of_range);
        const word_pair words = split_words(static_cast<u32>(p), device::facts.word_order);
        o.arguments[used++] = words.first;
        o.arguments[used++] = words.second;
    }
    return o;
}
inline constexpr std::int32_t longest_way = 0x7FFF'FFFE; // the next one is what a quantity saturates to
inline constexpr std::int32_t farthest_place = 0x3FFF'FFFF;
} // namespace detail

/// Relative position mode, synchronous: both wheels start together. Refused while a wheel moves. The move is
/// ordered once: after an unanswered start the positions are compared (`drive::motion()`), nothing is sent
/// again. Do not send it again yourself because no motion was seen: a short move may be over. Section 3.2.
constexpr prepared_command prepare(const wheel_ways& wanted, const cached_settings& cached) {
    return detail::move(routines::move_both, operating_mode::relative_position, synchronisation::synchronous,
                        cached, {wanted.left.count(), wanted.right.count()}, detail::longest_way);
}
/// Relative position mode, asynchronous: one wheel, while the other one is at rest or moves. Section 3.2.
struct move_left_by {
    distance left;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::move(routines::move_left, operating_mode::relative_position,
                            synchronisation::asynchronous, cached, {left.count(), 0}, detail::longest_way,
                            wheels::left);
    }
};
/// As `move_left_by`, of the right wheel.
struct move_right_by {
    distance right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::move(routines::move_right, operating_mode::relative_position,
                            synchronisation::asynchronous, cached, {right.count(), 0}, detail::longest_way,
                            wheels::right);
    }
};
/// Absolute position mode, synchronous: places within +-0x3FFFFFFF.
constexpr prepared_command prepare(const wheel_places& wanted, const cached_settings& cached) {
    return detail::move(routines::move_both, operating_mode::absolute_position, synchronisation::synchronous,
                        cached, {wanted.left.count(), wanted.right.count()}, detail::farthest_place);
}
/// Absolute position mode, asynchronous: one wheel.
struct move_left_to {
    distance left;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::move(routines::move_left, operating_mode::absolute_position,
                            synchronisation::asynchronous, cached, {left.count(), 0}, detail::farthest_place,
                            wheels::left);
    }
};
/// As `move_left_to`, of the right wheel.
struct move_right_to {
    distance right;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        return detail::move(routines::move_right, operating_mode::absolute_position,
                            synchronisation::asynchronous, cached, {right.count(), 0}, detail::farthest_place,
                            wheels::right);
    }
};

/// Waits until both wheels stand.
constexpr prepared_command prepare(const wait_standstill& wanted, const cached_settings& cached) {
    return {.steps = routines::wait_standstill,
            .arguments = {static_cast<std::uint16_t>(wheels::both)},
            .refusal = detail::needs_init_done(cached),
            .limit = wanted.limit};
}

/// Waits until the last move of these wheels has ended, within 20 counts of its target. Errors: as `wait_reached`;
/// `wrong_state` if they have no move since the last `init` or `enable`.
struct wait_wheels_reached {
    zlac8015d::wheels which;
    duration limit = milliseconds(60'000);

    constexpr prepared_command prepare(const cached_settings& cached) const {
        return {.steps = routines::wait_reached,
                .arguments = {static_cast<std::uint16_t>(which)},
                .then = effect::arrived,
                .refusal = detail::needs_init_done(cached),
                .limit = limit};
    }
};
/// As `wait_wheels_reached`, of both wheels.
constexpr prepared_command prepare(const wait_reached& wanted, const cached_settings& cached) {
    return wait_wheels_reached{wheels::both, wanted.limit}.prepare(cached);
}

/// Reads state, faults, positions and speeds in one frame; `drive::feedback` has them.
constexpr prepared_command prepare(read_feedback, const cached_settings& cached) {
    return {.steps = routines::feedback, .then = effect::seen, .refusal = detail::needs_init_done(cached)};
}

/// By which a take-over knows it: its plan for an unknown mode does not show it.
void moves_or_energises(const enable_in*);

} // namespace servobus::zlac8015d
