// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a command of a drive's own does, seen from outside: its author says it to sim/conformance.hpp.
//
//     constexpr sim::expected endless = sim::turns();
//     static_assert(sim::moves_by(2000).goal_from(500) == 2500);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::sim {

/// When a register of the drive tells that it has restarted.
enum class restart_shows : std::uint8_t { never, while_enabled, always };

/// Describes how much can be known of a drive under an interpretation of its manual.
struct what_shows {
    restart_shows restart = restart_shows::always;
    /// False: one is hidden that is over between the read of a register and the write that sets it again.
    bool restart_in_a_change = true;
    /// False: a drive that a wired stop has switched off reads as an enabled one.
    bool wired_stop = true;
    /// False: a motion that was started on a drive whose restart does not show may be one that no stop ends.
    bool every_stop = true;
};

struct expected {
    enum class kind : std::uint8_t { nothing, turns, moves_to, moves_by, homes_at };
    kind what = kind::nothing;
    std::int64_t where = 0; ///< in the counts of the machine's place
    /// True if the drive has nothing by which a restart between two of the command's requests shows.
    bool hides_restart = false;

    constexpr bool is_move() const { return what == kind::moves_to || what == kind::moves_by; }
    constexpr bool is_motion() const { return what != kind::nothing; }
    /// True if the command is under way until the motor is where it is to be.
    constexpr bool ends_at_goal() const { return what == kind::homes_at; }
    constexpr bool has_goal() const { return is_move() || ends_at_goal(); }
    /// Where a move ends that begins at `place`.
    constexpr std::int64_t goal_from(std::int64_t place) const {
        return what == kind::moves_by ? place + where : where;
    }
};

/// Nothing that shows from outside: a setting, a refresh.
constexpr expected changes_nothing() { return {}; }
/// The same, and a restart between two of its requests cannot be seen.
constexpr expected hides_a_restart() { return {.hides_restart = true}; }
/// The motor turns until it is stopped.
constexpr expected turns() { return {.what = expected::kind::turns}; }
/// The motor moves to a place, in the counts in which the machine's place is told.
constexpr expected moves_to(std::int64_t place) { return {.what = expected::kind::moves_to, .where = place}; }
/// The motor moves by a way.
constexpr expected moves_by(std::int64_t way) { return {.what = expected::kind::moves_by, .where = way}; }
/// The motor searches home. It rests at this place when the command is done, and does not turn on after one that fails:
/// so that this shows, home is three seconds away.
constexpr expected homes_at(std::int64_t place) { return {.what = expected::kind::homes_at, .where = place}; }

} // namespace servobus::sim
