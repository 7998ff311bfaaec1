// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A facade with next to nothing of a drive: a command is a routine as the test writes it, with its kind and its
// priority. For tests of what all facades share (control/facade.hpp).
#pragma once

#include <cstdint>

#include <servobus/control/facade.hpp>
#include <servobus/servobus.hpp>

namespace bare {

using namespace servobus; // NOLINT: as a test has it

struct settings {
    drive_state state = drive_state::needs_init;
    steps::recheck witness{}; ///< what the last take-over was given
};

/// A routine with its arguments. A take-over that is done makes the drive's state known.
struct command {
    routine steps;
    steps::arguments arguments{};
    command_kind then = command_kind::other;
    stop_priority stop = stop_priority::no_stop;
    errc refusal = errc::ok;
    std::uint16_t shift = 0;
    duration limit{};
    steps::recheck witness{}; ///< of a take-over
    bool makes_known = false; ///< although it is none

    constexpr command prepare(const settings&) const { return *this; }
};

class model {
  public:
    using prepared_command = bare::command;
    using settings = bare::settings;

    static constexpr drive_traits traits{};
    static constexpr feedback_blocks blocks{register_block{0x0110, 1}};
    static constexpr settings unknown{};
    static constexpr stop_rules stops{
        .at_fault = stop_priority::halt, .after_restart = false, .disable_replaces_quick_stop = false};

    /// A command's effect is its kind.
    struct own_kinds {
        constexpr command_kind operator[](command_kind k) const { return k; }
        constexpr bool sets_origin(command_kind k) const { return k == command_kind::take_over; }
        constexpr bool has_motion() const { return false; }
        constexpr bool moves(command_kind) const { return false; }
        constexpr bool is_complete() const { return true; }
        constexpr bool are_origins_stated() const { return true; }
    };
    static constexpr own_kinds kinds{};
    /// What the feedback says is the test's.
    static inline verdict (*judges)(std::uint16_t) = [](std::uint16_t) { return verdict::as_expected; };
    static verdict judge(const std::uint16_t* w, settings&) { return judges(w[0]); }
    static constexpr bool is_faulted(const std::uint16_t*, const settings&) { return false; }
    static constexpr bool has_fallen(const block_feedback&, const settings&) { return false; }
    static constexpr void note(const block_feedback&, const settings&) {}
    static constexpr duration watchdog(const settings&) { return {}; }
    static constexpr steps::recheck witness(const settings& known, const command&) { return known.witness; }
    /// The stop of a supervisor is the test's.
    static inline command stops_by{.steps = no_steps};
    static command stop_for(stop_priority, const settings&, bool) { return stops_by; }

    static constexpr errc admit(const command&, duration) { return errc::ok; }
    static constexpr errc permit(const command&, const situation&, const settings&) { return errc::ok; }
    static constexpr errc confirm(const command&, const situation&, const settings&) { return errc::ok; }
    constexpr errc learn(const command& c, const ending& e, settings& known) {
        ++(e.is_done ? done : failed);
        if (!e.is_done) return errc::ok;
        if (c.then == command_kind::take_over || c.makes_known) known = {drive_state::enabled, c.witness};
        return errc::ok;
    }
    static constexpr void preempt(const command&) {}

    unsigned done = 0;
    unsigned failed = 0;
};

template <class Line> class drive : public facade<model, Line> {
    using base = facade<model, Line>;

  public:
    template <class Node>
    drive(Line& on, const Node& at, duration feedback = {}) : base{on, at, feedback, no_command_timeout} {}

    using base::words, base::check_feedback;
    unsigned done() const { return this->model().done; }
    unsigned failed() const { return this->model().failed; }
};

} // namespace bare
