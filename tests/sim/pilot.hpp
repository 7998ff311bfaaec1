// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The program of a run of lives: the facade of one drive, what it can command, and what the simulated machine does,
// seen from outside. It is written apart from facade.hpp, on any line.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <servobus/control/command_status.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/core/time.hpp>

#include "facade.hpp"
#include "gateway.hpp"
#include "participant.hpp"
#include "played.hpp"

namespace trial {

/// Of each motor; the second is 0 where there is one.
using places = std::array<std::int64_t, 2>;

class pilot {
  public:
    pilot() = default;
    pilot(const pilot&) = delete;
    pilot& operator=(const pilot&) = delete;
    virtual ~pilot() = default;

    virtual participant& place() = 0;
    /// Prepares the simulated drive before the run, not by frames.
    virtual void prepare() {}

    // The program
    virtual servobus::errc begin(doing what, scene& on) = 0;
    /// Begins a setpoint of a motion without an end, or what is needed before one.
    virtual servobus::errc begin_setpoint(scene& on) = 0;
    virtual servobus::errc begin_turning_mode() = 0;
    /// Commands of this kind exist, in the state in which the drive is.
    virtual bool can(doing what) const = 0;
    virtual servobus::duration step() = 0;
    virtual bool is_idle() const = 0;
    virtual servobus::command_status last() const = 0;
    virtual bool needs_init() const = 0;
    virtual bool says_enabled() const = 0;
    virtual bool says_faulted() const = 0;
    virtual bool is_absent() const = 0;
    virtual servobus::arrival_state how() const = 0;
    virtual void set_command_timeout(servobus::duration limit) = 0;
    /// A register that may be written at any time.
    virtual std::uint16_t harmless_register() const = 0;
    /// The positions of the feedback, read at most `oldest()` ago, in the counts of the drive.
    virtual std::optional<places> feedback() const = 0;
    virtual servobus::duration oldest() const = 0;
    /// The position is read this often.
    virtual servobus::duration between_refreshes() const = 0;
    /// This frame stops the drive.
    virtual bool is_stop(servobus::bytes frame) const = 0;

    // The machine
    virtual places shaft() = 0; ///< never changed by a restart, in the counts of the feedback
    virtual places shown() = 0; ///< the drive's present position registers
    virtual bool stands() = 0;
    virtual bool has_power() = 0;
    virtual void fall_ill(scene& on) = 0; ///< a fault or an input acts on it until it recovers
    virtual bool has_fault() = 0;
    virtual void recover() = 0;
    /// A restart can be found, by the interpretation of the manual.
    virtual bool shows_restarts() const { return true; }
    /// Also while it is not enabled: the next command finds it.
    virtual bool shows_restarts_at_rest() const { return shows_restarts(); }
    /// Also while a stop is under way; otherwise once that is over.
    virtual bool shows_restarts_in_stop() const { return true; }
    /// The register of a marker by which a restart shows and which some commands write; 0 if there is none.
    virtual std::uint16_t marker_register() const { return 0; }
    /// A stop, or a save, writes these words there: a restart before it does not show any more.
    virtual bool hides_restart(const std::vector<std::uint16_t>&) const { return false; }
    /// A save has cleared it, until it is done.
    virtual bool is_marker_cleared() { return false; }
    /// A fault shows in what the drive is known to be.
    virtual bool shows_faults() const { return true; }
    /// Its own watchdog stops it. The next request may end that stop.
    virtual bool has_watchdog() const { return false; }
    /// The place at which the last move or homing must end, by motor; empty if it is not known.
    std::array<std::optional<std::int64_t>, 2> goal{};
    std::int64_t window = 0;    ///< around the goal
    std::int64_t tolerance = 0; ///< of a position of the feedback

    void forget_goals() { goal = {}; }
    bool is_at_goal() {
        const places at = shaft();
        for (std::size_t i = 0; i < at.size(); ++i) {
            if (goal[i] && (at[i] - *goal[i] > window || *goal[i] - at[i] > window)) return false;
        }
        return true;
    }
    bool has_goal() const { return goal[0] || goal[1]; }
};

template <class Line, class Seat, template <class> class Drive> class pilot_of : public pilot {
  public:
    pilot_of(Seat& at, Line& on, servobus::duration every)
        : drive{on, at.client.node(), servobus::supervision{every, servobus::no_command_timeout}}, at_{&at},
          every_{every} {}

    /// Interpretations of the manual by which this facade never enables the drive are replaced.
    template <class Options> static Options workable(const Options& drawn) { return drawn; }

    participant& place() override { return *at_; }
    servobus::duration step() override { return drive.step(); }
    bool is_idle() const override { return drive.is_idle(); }
    servobus::command_status last() const override { return drive.last(); }
    bool needs_init() const override { return drive.state() == state::needs_init; }
    bool says_enabled() const override { return drive.state() == state::enabled; }
    bool says_faulted() const override { return drive.state() == state::faulted; }
    bool is_absent() const override { return drive.is_absent(); }
    servobus::arrival_state how() const override { return drive.arrival().how; }
    void set_command_timeout(servobus::duration limit) override { drive.set_command_timeout(limit); }
    servobus::duration oldest() const override { return every_ * 3; }
    servobus::duration between_refreshes() const override { return every_; }

    Drive<Line> drive;

  protected:
    using state = decltype(std::declval<Drive<Line>>().state());

    auto& model() { return at_->model(); }
    template <class Options> Options chosen() const { return options_at<Options>(at_->positions()); }
    servobus::duration period() const { return every_; }

  private:
    Seat* at_;
    servobus::duration every_;
};

/// A way of a move: often back to where a restart begins to count, which is `count` 0, or near it.
inline std::int64_t draw_way(scene& on, std::int64_t count, std::int64_t least, std::int64_t most) {
    const auto size = static_cast<std::int64_t>(
        on.between(static_cast<std::uint32_t>(least), static_cast<std::uint32_t>(most)));
    const bool is_far = count > least || count < -least;
    if (is_far && on.one_in(2)) return -count;
    if (is_far && on.one_in(4)) return -count + static_cast<std::int64_t>(on.random.below(30)) - 15;
    return on.one_in(2) ? size : -size;
}

} // namespace trial
