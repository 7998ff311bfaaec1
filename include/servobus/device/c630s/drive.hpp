// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: the facade of a drive. Commands (commands.hpp, moves.hpp, parameters.hpp) are run to their end,
// or begun and stepped in a loop that never waits. The facade caches the settings of the drive and invalidates
// them when they may have changed; it is not a safety function. servobus/device/c630s.hpp includes it.
//
//     c630s::drive servo{wire, 1};
//     if (!servo.run(init{})) return 1;
//     if (servo.state() == c630s::drive_state::needs_set_up && !servo.run(c630s::set_up{})) return 1;
//     if (servo.needs_power_cycle()) std::puts("switch the drive off and on");
//     const result<std::int64_t> place = servo.read(c630s::wide_position::mechanical); // encoder counts
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/facade.hpp>
#include <servobus/device/c630s/model.hpp>

namespace servobus::c630s {

/// What every facade of a C630S has: `drive`, and that of an axis, whose model derives from the drive's.
template <class Line, class Model = model> class basic_drive : public facade<Model, Line> {
    using base = facade<Model, Line>;

  public:
    constexpr explicit basic_drive(Line& on, std::uint8_t at = 1, const supervision& by = without_watchdog)
        : basic_drive{on, servobus::node<device>{at}, by} {}
    /// With limits and gaps of its own.
    constexpr basic_drive(Line& on, const servobus::node<device>& at,
                          const supervision& by = without_watchdog)
        : base{on, at, by.feedback, by.command_timeout} {}

    /// The word order of 32-bit values; `unknown` before `init`, while a command may change it, and after a
    /// request without a response until the drive was checked, where that can be done (`restart_visible()`).
    constexpr word_order current_word_order() const {
        const bool may_change = !this->is_idle() && this->current().then == effect::forgotten;
        const bool is_known = this->cached().is_initialised() && (this->is_verified() || !restart_visible());
        return may_change || !is_known ? word_order::unknown : this->cached().word_order;
    }
    /// Whether a restart of the drive shows, by a virtual input without a function whose level a restart clears
    /// (P31-00, VDI16): read every 500 ms and after each request without a response. False before `init` and
    /// before the set-up works, when nothing can be moved.
    constexpr bool restart_visible() const { return this->cached().is_marked(); }
    /// True from a `set_up` or `keep` that changed something until `init` finds that the drive has been off.
    constexpr bool needs_power_cycle() const {
        return this->cached().state == drive_state::needs_power_cycle;
    }

    /// The feedback, read at most `oldest` ago. Where the facade is polled, the status is as old as its period, or as
    /// two while `read` is under way. One part of the rest is read with every second status: it is at most eight
    /// periods old.
    /// Errors: `needs_init`; `busy` while a command changes settings; `timeout` if any of it is older or was not read.
    constexpr result<c630s::feedback> feedback(duration oldest) const {
        errc why = this->check_feedback(oldest);
        if (why == errc::ok && !this->slower().are_younger(oldest, this->line().now())) why = errc::timeout;
        if (why != errc::ok) return why;
        return last_feedback();
    }
    /// After a start that ended `unknown`: whether the motor was found running, or more than 20 reference units
    /// from its place; `unknown` if the drive was restarted.
    constexpr motion_check motion() const { return this->model().motion().seen(); }
    /// Where the last move has come to; `none` in the state `needs_init`, for a run of several segments, and from the
    /// begin of a move until it has started. It ends when `wait_reached` or `wait_standstill` has read where the motor
    /// is, or a stop is done.
    constexpr c630s::arrival arrival() const {
        const motion_under_way& last = this->model().motion();
        if (!this->cached().is_initialised() || !last.has_goal() || this->is_move_beginning()) return {};
        c630s::arrival a{.how = last.how(), .missing = last.missing_at(last_feedback().position.count())};
        if (this->is_ended_by_fault(a.how)) a.how = arrival_state::stopped_short;
        if (a.how == arrival_state::stopped_short)
            a.cause = last.cause() != stop_cause::unknown ? last.cause() : this->cause();
        return a;
    }

    constexpr c630s::arrival arrival(const wait_reached&) const { return arrival(); }

    /// After `already_assigned`: the register that holds the function, such as `"P03-14"_p` for DI7, whose
    /// name is `c630s::catalogue.find(address)->name`; else 0.
    constexpr std::uint16_t conflicting_terminal() const { return this->model().conflict(); }

    using base::run;
    /// Runs a move and waits for its end. Returns how that was; `none` if the move did not begin, as `last` says.
    template <class Move> c630s::arrival run(const Move& move, const wait_reached& end) {
        commands::check_target<Move>();
        if (!base::run(move)) return {};
        (void)base::run(end);
        return arrival();
    }

    /// Reads the status in one frame. A fault while the drive is enabled switches the servo off before this
    /// returns.
    result<status_flags> read_status() {
        const command_status r = this->run(c630s::read_status{});
        if (!r) return servobus::status{r};
        return last_feedback().state;
    }
    /// Reads status, speed, torque, position, deviation and alarm in five frames. A fault while the drive is
    /// enabled switches the servo off before this returns.
    result<c630s::feedback> read() {
        const command_status r = this->run(read_feedback{});
        if (!r) return servobus::status{r};
        return last_feedback();
    }
    /// Reads a position of 64 bits, both halves from one frame.
    result<std::int64_t> read(wide_position which) {
        const word_order order = this->cached().word_order;
        const command_status r = this->run(read_wide_position{which});
        if (!r) return servobus::status{r};
        return read_wide_position::from_words(this->words(), order);
    }
    /// Reads entry 0 (the present one) to 9 of the fault history. If it fails on entry 9 half-way, the next
    /// `init` asks for a power cycle that is not needed.
    result<fault_entry> fault(unsigned entry) {
        const word_order order = this->cached().word_order;
        const command_status r = this->run(read_fault{entry});
        if (!r) return servobus::status{r};
        return fault_entry::from_words(this->words(), order);
    }

  private:
    constexpr c630s::feedback last_feedback() const {
        std::uint16_t words[c630s::feedback::size]{this->image()[0]};
        for (std::size_t i = 1; i < c630s::feedback::size; ++i) words[i] = this->slower().words(1)[i - 1];
        return c630s::feedback::from_words(words, this->cached().word_order);
    }
};

/// One C630S on a line.
///
///     c630s::drive servo{wire, 1};
///     if (!servo.run(init{})) ...
///     if (servo.state() == drive_state::needs_set_up && !servo.run(set_up{})) ...
///     if (servo.needs_power_cycle()) ... // switch the drive off and on, then init again
///     if (!servo.run(enable_in{control_mode::speed})) ...
///     if (!servo.run(velocity{300 * r_per_min})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` in each loop iteration. After an unknown
/// outcome or a restart of the drive the state is `needs_init`, and no motion is commanded until `init` has run:
/// motion never resumes by itself. A restart shows as `restart_visible()` says.
///
/// **The drive has no documented watchdog.** When the line or this program is lost, it continues with its last
/// command: a speed, a torque or a jog without end. A command timeout covers a program that has stopped
/// commanding but still steps; for the rest a wired stop is needed.
template <class Line> class drive : public basic_drive<Line> {
    using basic_drive<Line>::basic_drive; // C++20 deduces no `Line` from them: the guides do
};
template <class Line> drive(Line&, std::uint8_t) -> drive<Line>;
template <class Line> drive(Line&, std::uint8_t, const supervision&) -> drive<Line>;
template <class Line> drive(Line&, const servobus::node<device>&) -> drive<Line>;
template <class Line> drive(Line&, const servobus::node<device>&, const supervision&) -> drive<Line>;
template <class Line> drive(Line&) -> drive<Line>;

} // namespace servobus::c630s
