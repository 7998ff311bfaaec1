// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLTECH ZLAC8015D: the facade of a drive. Commands (commands.hpp) are run to their end, or begun and
// stepped in a loop that never waits. The facade caches the settings of the drive and invalidates them
// when they may have changed; it is not a safety function. servobus/device/zlac8015d.hpp includes it.
//
//     zlac8015d::drive wheels{wire, 1, {.command_timeout = milliseconds(300)}};
//     if (!wheels.run(init{})) return 1;
//     const result<zlac8015d::feedback> seen = wheels.read(); // one request
//     if (!seen || seen->has_fault()) return 1;
//     if (seen->left_speed > 10 * r_per_min) std::puts("the left wheel turns");
#pragma once

#include <cstdint>

#include <servobus/core/slice.hpp>
#include <servobus/device/zlac8015d/model.hpp>

namespace servobus::zlac8015d {

/// What the drive says of itself in one frame.
struct feedback {
    status_flags state{};
    hall_inputs hall{};
    motor_temperatures temperature{}; ///< degC
    faults left_faults{};
    faults right_faults{};
    reading<left_actual_position> left_position{};
    reading<right_actual_position> right_position{};
    reading<left_actual_speed> left_speed{};   ///< counts of 0.1 r/min
    reading<right_actual_speed> right_speed{}; ///< counts of 0.1 r/min

    constexpr bool has_fault() const { return left_faults.any() || right_faults.any(); }
    constexpr bool is_moving() const { return state.is_running(); }

    /// Takes the eleven words of 20A2h..20ACh.
    static constexpr feedback from_words(slice<const std::uint16_t> w) {
        constexpr word_order which = device::facts.word_order;
        feedback f;
        f.state = status_flags::from_word(w[0]);
        f.hall = hall_inputs::from_word(w[1]);
        f.temperature = motor_temperatures::from_word(w[2]);
        f.left_faults = {w[3]};
        f.right_faults = {w[4]};
        f.left_position = servobus::reading_of<left_actual_position>(join_words(w[5], w[6], which));
        f.right_position = servobus::reading_of<right_actual_position>(join_words(w[7], w[8], which));
        f.left_speed = servobus::reading_of<left_actual_speed>(w[9]);
        f.right_speed = servobus::reading_of<right_actual_speed>(w[10]);
        return f;
    }
};

/// What every facade of a ZLAC8015D has: `drive`, and those of robots and axes, whose models derive from the drive's.
template <class Line, class Model = model> class basic_drive : public facade<Model, Line> {
    using base = facade<Model, Line>;

  public:
    constexpr basic_drive(Line& on, std::uint8_t at, const supervision& by)
        : basic_drive{on, servobus::node<device>{at}, by} {}
    /// With limits and gaps of its own.
    constexpr basic_drive(Line& on, const servobus::node<device>& at, const supervision& by)
        : base{on, at, by.feedback, by.command_timeout} {}

    /// The feedback, read at most `oldest` ago. Errors: `needs_init`; `busy` while a command changes settings, and
    /// during `init`; `timeout` if it is older or none was read.
    constexpr result<zlac8015d::feedback> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return last_feedback();
    }
    /// After a move ended `unknown`: whether a wheel was found running, or more than 20 counts from its
    /// place; `unknown` if the drive was restarted.
    constexpr motion_check motion() const { return this->model().motion(); }

    /// Where the last move has come to, by the last feedback; `none` in the state `needs_init`, after `init` until the
    /// next move, since a restart changes the positions, from the begin of a move of these wheels until it has started,
    /// and after one that was replaced, failed, or was refused otherwise than as `busy`.
    constexpr zlac8015d::arrival arrival(wheels which = wheels::both) const {
        if (this->state() == drive_state::needs_init) return {};
        const auto begins = static_cast<unsigned>(this->current().which) & static_cast<unsigned>(which);
        if (this->is_move_beginning() && begins != 0) return {};
        zlac8015d::arrival a = this->model().arrival_of(which, this->image(), this->since_start());
        if (this->is_ended_by_fault(a.how)) a.how = arrival_state::stopped_short;
        if (a.how == arrival_state::stopped_short) a.cause = this->cause();
        return a;
    }

    /// Where the wheels have come to for which `end` waits.
    constexpr zlac8015d::arrival arrival(const wait_wheels_reached& end) const { return arrival(end.which); }
    constexpr zlac8015d::arrival arrival(const wait_reached&) const { return arrival(); }

    using base::run;
    /// Runs a move and waits for its end. Returns how that was; `none` if the move did not begin, as `last`
    /// says.
    template <class Move> zlac8015d::arrival run(const Move& move, const wait_reached& end) {
        commands::check_target<Move>();
        return run_until(move, end);
    }
    template <class Move> zlac8015d::arrival run(const Move& move, const wait_wheels_reached& end) {
        return run_until(move, end);
    }

    /// Reads state, faults, positions and speeds in one frame. A fault on one wheel while the drive is
    /// enabled stops both before this returns.
    result<zlac8015d::feedback> read() {
        const command_status r = this->run(read_feedback{});
        if (!r) return servobus::status{r};
        return last_feedback();
    }

  private:
    template <class Move, class End> zlac8015d::arrival run_until(const Move& move, const End& end) {
        if (!base::run(move)) return {};
        (void)base::run(end);
        return arrival(end);
    }
    constexpr zlac8015d::feedback last_feedback() const {
        return zlac8015d::feedback::from_words({this->image(), Model::blocks.image().words});
    }
};

/// One ZLAC8015D on a line.
///
///     zlac8015d::drive wheels{wire, 1, {.command_timeout = milliseconds(300)}};
///     if (!wheels.run(init{})) ...
///     if (!wheels.run(enable_in{operating_mode::velocity})) ...
///     if (!wheels.run(velocity{30 * r_per_min, -30 * r_per_min})) ...
///
/// In a superloop `begin(command)` instead of `run`, and `step()` in each loop iteration. When the drive's
/// watchdog may have expired, after an unknown outcome or a restart of the drive the state is `needs_init`, and
/// no motion is commanded until `init` has run: motion never resumes by itself. (Time is measured by a clock
/// that wraps after 71 minutes: a program that may rest as long calls `step()` meanwhile, or `init` first.)
template <class Line> class drive : public basic_drive<Line> {
    using basic_drive<Line>::basic_drive; // C++20 deduces no `Line` from them: the guides do
};
template <class Line> drive(Line&, std::uint8_t, const supervision&) -> drive<Line>;
template <class Line> drive(Line&, const servobus::node<device>&, const supervision&) -> drive<Line>;

} // namespace servobus::zlac8015d
