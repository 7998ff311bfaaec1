// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC Modbus steppers: `hold` turns the motor while a button is held, though the drive has no watchdog: each
// command is a move that ends by itself. servobus/device/yako.hpp includes it. Source: manual V2.6.0, section 4.1.
//
//     void jog(auto& axis, bool is_pressed) { // in each loop iteration
//         if (axis.step(); !axis.is_idle()) return;
//         constexpr hold down{-30 * units::r_per_min, milliseconds(50)};
//         (void)(is_pressed ? axis.begin(down) : axis.begin(halt{}));
//     }
#pragma once

#include <cstdint>

#include <servobus/device/yako/commands.hpp>

namespace servobus::yako {

/// The bounds of `every`.
inline constexpr duration shortest_hold = milliseconds(1);
inline constexpr duration longest_hold = milliseconds(1000);

/// The way from the position seen to the target of one command: speed x (2 x `every` + 50 ms + `deceleration`),
/// or at most 2 % and 32 pulses more. The 50 ms are for the frames and the drive's start. The second `every` and
/// half of the deceleration leave time for a late command.
constexpr distance reach(const held_velocity& wanted, const cached_settings& cached) {
    constexpr std::uint32_t delay_ms = 50;
    const speed top = wanted.target.count() < 0 ? -wanted.target : wanted.target;
    const std::uint32_t period = (wanted.every.us >> 10) + (wanted.every.us >> 15) + 1; // ms
    const std::uint32_t ms = 2 * period + delay_ms + static_cast<std::uint32_t>(wanted.deceleration.count());
    // Shifts in place of divisions, which a small core lacks: 7 / 4096 / 1024 is 1 / 600 000 and 0.1 % more.
    const std::uint32_t pace = (static_cast<std::uint32_t>(top.count()) * cached.microsteps >> 12) * 7 + 7;
    const std::uint32_t way = (pace >> 10) * ms + ((pace & 1023u) * ms >> 10) + 1;
    return distance{static_cast<std::int32_t>(wanted.target.count() < 0 ? 0u - way : way)};
}

namespace detail {
// A motion under way has the same speed and ramps. The target lies within the counter's range.
constexpr errc aim_of_hold(prepared_command& c, const std::uint16_t* feedback, const cached_settings& known) {
    using namespace routines;
    const bool is_moving = motion_status::from_word(feedback[status_at]).is_moving();
    for (std::size_t i = 0; is_moving && i < cached_settings::profile_words; ++i) {
        if (c.arguments[i] != known.profile[i]) return errc::busy;
    }
    const u32 from = join_words(feedback[position_at], feedback[position_at + 1u], known.word_order);
    const u32 to = from + static_cast<u32>(c.target);
    const word_pair words = split_words(to, known.word_order);
    c.arguments[4] = words.first;
    c.arguments[5] = words.second;
    const auto place = static_cast<std::int32_t>(to);
    const bool is_within = (c.target < 0) == (place < static_cast<std::int32_t>(from));
    return is_within ? in_range(distance{place}) : errc::out_of_range;
}
} // namespace detail

/// Turns at a speed for as long as the program repeats the command; `halt` ends it. Each command is an absolute move to
/// the position that the drive shows, plus `reach`, and interrupts the one before (bit 3 of 0027h). So the motor never
/// turns on by more than `reach` from a position that was read, and comes to rest there by its deceleration time:
/// - The program stops stepping, or steps and stops repeating, or the line is lost: no further target is set.
/// - The response to the target or to the start is lost, or the start itself: as after any such command (G21) the state
///   is `needs_init`, and only `init`, which stops the motor, leads on. Reads that are lost are repeated.
/// - The drive restarts: `needs_init`, and a drive that is energised is stopped.
///
/// [U] How a real drive passes from one move to the next is not stated. In simulation it keeps its speed, and has
/// turned on by 190..240 pulses of a reach of 252 (60 r/min, each 50 ms) after the program had stopped.
///
/// The axis need not be homed: the manual does not ask for it, and the way counts from the position that is seen [U].
/// Software limits (after homing) and limit inputs stop the motor as in any move, by 0017h. It leaves no target behind:
/// `arrival()` is none and `wait_reached` is refused (`wrong_state`); `wait_standstill` waits for its end.
///
/// Errors: `busy` while the motor moves otherwise, also for another direction, speed or ramp: `halt` first, since the
/// way that such a change takes is not stated [errata A32]. A bounded jog of the same profile is gone on with, and
/// leaves a hold as it is. `out_of_range` for a speed of zero or beyond 3000 r/min, times beyond 2000 ms, `every`
/// beyond 1 ms..1 s, and a target beyond the 32 bits of the position, where the motor comes to rest: declare another
/// position. `unexpected_value` if 0011h held none of its range at `init`. `not_reached` if the motor rests again: an
/// input, or an `every` that is shorter than the program and the line take. Otherwise as `move_by`.
constexpr prepared_command prepare(const held_velocity& wanted, const cached_settings& cached) {
    const bool is_forward = wanted.target.count() > 0;
    const motion_profile by{
        {}, wanted.acceleration, wanted.deceleration, is_forward ? wanted.target : -wanted.target};
    prepared_command o = detail::move<positioning::absolute>(distance{}, by, while_moving::interrupt, cached);
    const bool is_known = microstep_resolution.limits.contains(cached.microsteps);
    const bool is_time = wanted.every >= shortest_hold && wanted.every <= longest_hold;
    o.then = effect::crept;
    o.needs = at_rest_and_able; // unless it goes on
    o.is_absolute = false;      // its target is counted from the position that is seen
    o.aim = detail::aim_of_hold;
    o.refusal =
        detail::first_error(o.refusal, is_time && wanted.target.count() != 0 ? errc::ok : errc::out_of_range,
                            is_known ? errc::ok : errc::unexpected_value);
    if (o.refusal == errc::ok) o.target = reach(wanted, cached).count();
    return o;
}

} // namespace servobus::yako
