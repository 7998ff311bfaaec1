// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands of an axis, in lengths and speeds of the machine. The `axis_drive` of each device makes commands of the
// drive's own of them; its page says what differs. Programs get it with the header of that facade.
//
//     if (!lift.run(travel_limits{.lowest = -2_mm, .highest = 200_mm})) return 1;
//     constexpr axis_profile fast{.top = 50_mm_per_s, .acceleration = 200_ms, .deceleration = 200_ms};
//     const axis_arrival there = lift.run(travel_to{125.5_mm, fast}, wait_reached{});
//     if (there.how != arrival_state::reached) std::printf("%ld um missing\n", long(there.missing.count()));
#pragma once

#include <cstdint>

#include <servobus/axis/axis.hpp>
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

/// Moves to a place, to the nearest count.
struct travel_to {
    micrometres place;
    axis_profile by{};
};

/// Moves by a way; its sign is the direction. What rounding to counts leaves goes into the next one: a thousand moves
/// do not drift. It is carried once the move has begun, and forgotten where the position is counted from elsewhere.
struct travel_by {
    micrometres way;
    axis_profile by{};
};

/// Moves at a speed until another command; its sign is the direction. To the nearest count of the drive's speed.
struct travel_at {
    micrometres_per_second speed;
};

/// Moves at a speed while the program repeats it, as the drive's own `hold`; `halt` ends it. `every`: the longest time
/// from one command to the next.
struct hold_at {
    micrometres_per_second speed;
    duration every;
};

/// Limits the travel by software. From the factory a YAKO frees its motor beyond a limit: `yako::set_over_travel_stop`.
/// Errors: `bad_argument` if `lowest` is not below `highest`.
struct travel_limits {
    micrometres lowest;
    micrometres highest;
};

/// Says that the axis, where it stands, is at `place`.
struct declare_place {
    micrometres place;
};

// No take-over has them.
void moves_or_energises(const travel_to*);
void moves_or_energises(const travel_by*);
void moves_or_energises(const travel_at*);
void moves_or_energises(const hold_at*);

/// Where the last move of an axis has come to.
struct [[nodiscard]] axis_arrival {
    arrival_state how = arrival_state::none;
    stop_cause cause = stop_cause::unknown; ///< why it `stopped_short`
    micrometres missing{};                  ///< from where the axis is to its target

    /// At rest at its target.
    constexpr explicit operator bool() const { return how == arrival_state::reached; }
};

} // namespace servobus
