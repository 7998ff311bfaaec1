// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands of an axis: those of control/motion_commands.hpp in lengths and speeds of the machine. The `axis_drive`
// of each device makes commands of the drive's own of them; its page says what differs. Programs get it with the header
// of that facade.
//
//     if (!lift.run(limit_travel{-2_mm, 200_mm})) return 1;
//     constexpr axis_profile fast{.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms};
//     const axis_arrival there = lift.run(move_to{125.5_mm, fast}, wait_reached{});
//     if (!there) std::printf("%ld um missing\n", long(there.missing.count()));
#pragma once

#include <cstdint>

#include <servobus/axis/axis.hpp>
#include <servobus/control/motion_commands.hpp>
#include <servobus/control/states.hpp>

namespace servobus {

/// How a place is reached. Made without anything it is the profile that the drive holds; otherwise top speed and both
/// ramps are above 0, and the start is not above the top: `bad_argument`.
struct axis_profile {
    micrometres_per_second top{}; ///< above 0, to the nearest count of the drive's speed
    quantity<unit{measure::millisecond}> acceleration{}; ///< from standstill to `top`
    quantity<unit{measure::millisecond}> deceleration{}; ///< from `top` to standstill
    micrometres_per_second start{};                      ///< at which a stepper begins

    constexpr bool is_stored() const {
        return top.count() == 0 && acceleration.count() == 0 && deceleration.count() == 0 &&
               start.count() == 0;
    }
    /// Of one that is not stored.
    constexpr bool is_whole() const {
        return top.count() > 0 && acceleration.count() > 0 && deceleration.count() > 0 &&
               start.count() >= 0 && start <= top;
    }
};

/// The moves of an axis. `move_to{place}` is by the profile that the drive holds, `move_to{place, profile}` by another
/// one, which may be written in braces. A place is rounded to the nearest count. The rest of a way, `move_by`, that is
/// rounded goes into the next one: a thousand moves do not drift. The rest is carried once the move has begun. It is
/// forgotten where the position is counted from elsewhere.
template <unit U, class Rep>
requires(detail::same_kind(U, units::micrometre)) move_to(quantity<U, Rep>, axis_profile = {})
->move_to<detail::kept<quantity<U, Rep>>, axis_profile>;
template <unit U, class Rep>
requires(detail::same_kind(U, units::micrometre)) move_by(quantity<U, Rep>, axis_profile = {})
->move_by<detail::kept<quantity<U, Rep>>, axis_profile>;

/// The moves of an axis, as their type.
using axis_move_to = move_to<micrometres, axis_profile>;
using axis_move_by = move_by<micrometres, axis_profile>;
/// A speed of an axis, to the nearest count of the drive's speed; and one that is held.
using axis_velocity = velocity<micrometres_per_second>;
using axis_hold = hold<micrometres_per_second, duration>;

/// Where the last move of an axis has come to.
struct [[nodiscard]] axis_arrival {
    arrival_state how = arrival_state::none;
    stop_cause cause = stop_cause::unknown; ///< why it `stopped_short`
    micrometres missing{};                  ///< from where the axis is to its target

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == arrival_state::reached; }
};

} // namespace servobus
