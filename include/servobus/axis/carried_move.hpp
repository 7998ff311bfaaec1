// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Relative moves that do not drift: a length is converted to counts, and what is lost by rounding goes into the next
// move. The rest changes only when a move has ended done, so a move that was refused or stopped may be repeated.
//
//     constexpr carried_move slide{scale::of(250, 1270)}; // counts of um: 1000 counts, 5.08 mm
//     constexpr planned_move m = slide.plan(micrometres{100}).value();
//     static_assert(m.counts == 20); // 19.7; after commit(m), the next 100 um are 19 counts
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>

namespace servobus {

/// A relative move as the drive counts it, and what it leaves for the next one.
struct planned_move {
    std::int32_t counts = 0;
    std::int32_t rest = 0; ///< in parts of a count, of the scale's denominator
};

/// Converts relative moves to counts and carries their rest.
class carried_move {
  public:
    constexpr explicit carried_move(const scale& counts_of_um,
                                    count_direction direction = count_direction::forward)
        : counts_of_um_{counts_of_um}, direction_{direction} {}

    /// The counts of a move by `distance` after the moves that are committed, at most half a count off. Nothing changes.
    /// Errors: out_of_range (`distance` is beyond `most()` of the scale).
    constexpr result<planned_move> plan(micrometres distance) const {
        const std::int64_t most = counts_of_um_.most();
        if (distance.count() > most || distance.count() < -most) return errc::out_of_range;
        planned_move planned{0, rest_};
        const result<std::int32_t> forward =
            counts_of_um_.convert(static_cast<std::int32_t>(distance.count()), planned.rest);
        if (!forward) return forward.error();
        planned.counts = direction_ == count_direction::forward ? *forward : -*forward;
        return planned;
    }

    /// Keeps the rest of a planned move that has ended done.
    constexpr void commit(const planned_move& done) { rest_ = done.rest; }

    /// Drops the rest: the next move begins at a position that is not the last target, as after homing.
    constexpr void reset() { rest_ = 0; }

    /// The rest of the committed moves, in parts of a count of the scale's denominator.
    constexpr std::int32_t rest() const { return rest_; }

  private:
    scale counts_of_um_;
    std::int32_t rest_ = 0;
    count_direction direction_;
};

} // namespace servobus
