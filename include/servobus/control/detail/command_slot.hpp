// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The command under way: whose it is, its routine, which command may replace it, how it ended, and what makes a
// supervisor stop the drive. It sends nothing and knows nothing of the drive.
#pragma once

#include <cstdint>
#include <type_traits>

#include <servobus/control/command_status.hpp>
#include <servobus/control/detail/routine_run.hpp>
#include <servobus/control/detail/supervisors.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>

namespace servobus::detail {

constexpr bool is_motion(command_kind k) {
    return k == command_kind::endless_motion || k == command_kind::move;
}

/// A stop that a supervisor begins.
struct due_stop {
    stop_priority how = stop_priority::no_stop;
    std::uint8_t urgent = 0; ///< frames that go before all other traffic
    bool is_of_command_timeout = false;
};

template <class Model> class command_slot {
  public:
    using prepared_command = typename Model::prepared_command;

    constexpr explicit command_slot(duration command_timeout) : supervisors_{command_timeout} {}

    constexpr bool is_idle() const { return owner_ == owner::none; }
    constexpr const prepared_command& command() const { return command_; }
    constexpr prepared_command& command() { return command_; }
    constexpr const routine_run& run() const { return run_; }
    constexpr routine_run& run() { return run_; }
    constexpr const detail::supervisors& supervisors() const { return supervisors_; }
    constexpr detail::supervisors& supervisors() { return supervisors_; }

    constexpr command_kind kind() const { return kind_; }
    constexpr bool is_at(command_kind k) const { return !is_idle() && kind_ == k; }
    constexpr bool is_stopping() const { return !is_idle() && command_.stop != stop_priority::no_stop; }
    constexpr owner by() const { return owner_; }
    /// A stop confirms the state in which it leaves the drive.
    constexpr bool changes_settings() const {
        if (command_.stop != stop_priority::no_stop) return false;
        return kind_ == command_kind::setting || kind_ == command_kind::power ||
               kind_ == command_kind::take_over;
    }
    /// True while the feedback may contradict the cached settings: a stop or a change of settings is under way.
    constexpr bool is_changing() const { return is_stopping() || (!is_idle() && changes_settings()); }
    /// Positions are counted from elsewhere after the command.
    constexpr bool is_setting_origin() const { return !is_idle() && Model::kinds.sets_origin(command_.then); }
    constexpr bool is_setpoint_of_application() const {
        return owner_ == owner::application && kind_ == command_kind::endless_motion;
    }

    /// True if a command replaces the routine under way. A stop of a higher priority does. A take-over replaces a
    /// supervisor's stop, since it begins with every kind of stop.
    constexpr bool yields_to(const prepared_command& next) const {
        if (next.stop == stop_priority::no_stop)
            return owner_ == owner::supervisor && Model::kinds[next.then] == command_kind::take_over;
        if constexpr (Model::stops.disable_replaces_quick_stop) {
            if (next.stop == stop_priority::disable && command_.stop == stop_priority::quick_stop)
                return true;
        }
        return owner_ == owner::supervisor ? next.stop >= command_.stop : next.stop > command_.stop;
    }
    constexpr void begin(owner by, std::uint8_t urgent, instant now) {
        std::uint16_t shift = 0;
        if constexpr (requires { command_.shift; }) shift = command_.shift;
        owner_ = by;
        kind_ = Model::kinds[command_.then];
        run_.begin(command_.steps, command_.arguments, shift, command_.limit, urgent, by == owner::follow_up,
                   now);
    }
    /// Ends the routine, unless it reads the feedback: then it has succeeded.
    constexpr void end_unless_reading(errc why) {
        if (!is_idle() && kind_ != command_kind::refresh) run_.end(why, false);
    }
    /// The routine has ended. Returns whose it was.
    [[gnu::noinline]] constexpr owner end(instant now) {
        const command_status& r = run_.result();
        const owner by = owner_;
        if (by == owner::application || (by == owner::follow_up && !r && (is_stopping() || report_)))
            report_ = r;
        if (is_stopping()) note_stop(r, now);
        owner_ = owner::none;
        return by;
    }
    /// The command of that kind is done, and the model has found `found`.
    [[gnu::noinline]] constexpr void note_done(command_kind kind, errc found) {
        if (kind >= command_kind::endless_motion) supervisors_.close_stop();
        if (kind == command_kind::take_over) supervisors_.end_watch(); // it begins with a stop
        if (found != errc::ok) report_ = {status{found}.with_sent(run_.has_written()), 0, run_.has_written()};
    }
    /// The drive was energised. `moves`: it moves by that.
    constexpr void note_enabled(bool moves, instant now) {
        run_.note_zero_targets();
        supervisors_.end_watch(); // until it is commanded to move
        if (moves) supervisors_.watch(now);
    }

    // --- The supervisors

    constexpr void watch(instant now) {
        if (kind_ == command_kind::endless_motion) supervisors_.watch(now);
        if (kind_ == command_kind::move) supervisors_.end_watch();
    }
    /// The stop that a supervisor begins now, `no_stop` for none. `runs_without_port`: a drive without a watchdog may
    /// run.
    [[gnu::always_inline]] constexpr due_stop due_stop_at(instant now, bool runs_without_port) {
        if ((supervisors_.is_stop_due(now) || runs_without_port) && is_idle()) {
            stop_tries_ = 0;
            const bool is_open = supervisors_.is_stop_open();
            return {is_open ? supervisors_.open_priority() : stop_priority::halt,
                    supervisors_.is_stop_due(now) ? supervisors_.urgent_left() : steps::urgent_frames, false};
        }
        if (!has_run_out(now)) return {};
        return {stop_priority::halt, give_up_to_supervisor(), true};
    }
    /// The application has stopped commanding a motion that does not end by itself.
    constexpr bool has_run_out(instant now) const {
        if (!supervisors_.has_run_out(now) || is_stopping()) return false;
        // A setpoint that awaits its response shows that the program is alive: the time begins again at its end. A
        // take-over begins with a stop.
        return !is_setpoint_of_application() && !is_at(command_kind::take_over);
    }
    /// The supervisor's stop takes the place of what is under way. Returns how urgent it is: while another stop is
    /// repeated, no more than that.
    constexpr std::uint8_t give_up_to_supervisor() {
        supervisors_.end_watch();
        stop_tries_ = 0;
        if (!is_idle()) {
            ++number_;
            report_ = command_status{status::sent(errc::command_timeout)};
        }
        return supervisors_.is_stop_open() ? supervisors_.urgent_left() : steps::urgent_frames;
    }
    /// Leaves the stop under way open: it has ended without confirmation, or a take-over replaces it. A take-over that
    /// succeeds closes the stop. `was_sent`: the step under way. Returns how many frames of either are still urgent.
    [[gnu::noinline]] constexpr std::uint8_t keep_stop_open(bool was_sent, instant now) {
        supervisors_.leave_stop_open(command_.stop, run_.urgent_left(), run_.has_written() || was_sent, now);
        return run_.urgent_left();
    }

    // --- What the application is told

    constexpr const command_status& report() const { return report_; }
    constexpr void set_report(const command_status& r) { report_ = r; }
    constexpr std::uint8_t number() const { return number_; }
    constexpr void count_command() {
        ++number_;
        stop_tries_ = 0;
    }

    /// A stop that does not read back was acknowledged by a late response to another write: once more, a few times.
    constexpr bool is_to_be_tried_again() {
        return is_stopping() && owner_ != owner::follow_up &&
               run_.result().error() == errc::unexpected_value && ++stop_tries_ < tries_of_a_stop;
    }

  private:
    constexpr void note_stop(const command_status& r, instant now) {
        if (r && command_.stop >= stop_priority::disable) supervisors_.end_watch();
        // The halt of the command timeout ends no disable that is open.
        if (r && (command_.stop >= supervisors_.open_priority() || owner_ != owner::supervisor))
            supervisors_.close_stop();
        else
            (void)keep_stop_open(false, now);
    }

    static constexpr prepared_command none() {
        if constexpr (std::is_aggregate_v<prepared_command>) {
            return {.steps = no_steps};
        } else {
            return prepared_command{no_steps}; // with more than the drive's own
        }
    }

    static constexpr std::uint8_t tries_of_a_stop = 3;

    owner owner_ = owner::none;
    command_kind kind_ = command_kind::other;
    std::uint8_t number_ = 0; // of the application's command
    std::uint8_t stop_tries_ = 0;
    prepared_command command_ = none();
    detail::supervisors supervisors_;
    command_status report_{};
    routine_run run_{};
};

} // namespace servobus::detail
