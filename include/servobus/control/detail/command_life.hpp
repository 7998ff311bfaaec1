// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The life of a command in a drive's machine: whether it may begin, what it replaces, what its end changes of what is
// known of the drive, which routine follows, and when a supervisor or a fault stops the drive. It sends nothing.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/drive_frame.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/detail/unwatched_motion.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervised_node.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::detail {

template <class Model, class Exchange> class command_life {
  public:
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;
    /// True for a drive without a watchdog: its motor runs on when nothing is sent.
    static constexpr bool runs_without_line = !polling<Model>::has_watchdog;

    constexpr std::uint8_t address() const { return known_.address(); }
    constexpr const knowledge<Model>& known() const { return known_; }
    /// Gives a facade the model, for what only its own drive knows, such as the geometry of an axis.
    constexpr Model& model() { return known_.model(); }
    constexpr const command_slot<Model>& slot() const { return slot_; }
    constexpr const response_limits& limits() const { return limits_; }
    constexpr const bus_gaps& gaps() const { return gaps_; }

    /// True if the settings are known and the link has held until now.
    constexpr bool is_known(instant now, epoch at) const {
        return known_.is_known() && known_.link().holds(now, at);
    }
    /// The cached settings, if they are still valid now.
    template <class Line> constexpr const settings& valid_settings(instant now, const Line& on) {
        (void)check_link(now, on);
        if (known_.link().is_expired()) known_.invalidate();
        return known_.cached();
    }
    /// Starts a command that was planned with `valid_settings`.
    constexpr errc accept(prepared_command& next, instant now) {
        if (const errc refusal = refusal_of(next); refusal != errc::ok) {
            drop_target(next, refusal);
            return refusal;
        }
        if (!slot_.is_idle() && leaves_unknown()) {
            known_.invalidate();
            // The frames of a stop follow from what is known.
            if (next.stop != stop_priority::no_stop)
                next = Model::stop_for(next.stop, known_.cached(), false);
        }
        if (next.steps.empty()) return errc::bad_argument; // `no_steps` without a reason
        return take(next, now);
    }
    /// `last` says why a command was refused, unless that of the command under way is due.
    constexpr errc note_refusal(errc refusal) {
        if (refusal != errc::ok && slot_.is_idle()) slot_.set_report(routine_status{refusal});
        return refusal;
    }
    /// Time passes: the link is checked, and a supervisor may begin a stop. True if a command has ended or begun.
    template <class Line> constexpr bool pass(instant now, const Line& on) {
        const bool has_ended = check_link(now, on);
        return supervise(now) || has_ended;
    }
    /// Ends the command under way with an error. The exchange may be dropped.
    constexpr void give_up(errc why, instant now) {
        if (slot_.is_idle()) return;
        const bool was_written = frame_.is_step_sent(exchange_) && is_write();
        frame_.drop();
        slot_.run().end(why, was_written);
        settle(now);
    }

    /// The line was told of a change of settings that this machine's own command makes.
    constexpr void note_own_change() { known_.link().skip_change(); }

    constexpr void note_command(instant now) { slot_.supervisors().note_command(now); }
    constexpr void set_command_timeout(command_timeout limit, instant now) {
        slot_.supervisors().set_limit(limit.limit(), now);
    }
    constexpr void repeat_stops(duration every) { slot_.supervisors().repeat_stops(every); }
    /// Takes over what a plan states for the drive.
    constexpr void adopt(const supervised_node& as, duration stop_every, duration retry_every,
                         duration longest_response, instant now) {
        limits_ = as.limits;
        gaps_ = as.gaps;
        known_.polling().set_period(as.by.feedback);
        known_.polling().absence().set_period(retry_every);
        set_command_timeout(as.by.command_timeout, now);
        repeat_stops(stop_every);
        bound_response(longest_response);
    }
    /// Waits no longer for a response than the plan counts with, though the drive may say that it responds later.
    constexpr void bound_response(duration longest) {
        if (longest < limits_.response) limits_.response = longest;
    }
    /// A plan has another drive in its place: it is polled no more and refuses all commands but stops.
    constexpr void refuse() {
        is_refused_ = true;
        known_.polling().set_period({});
    }
    /// Sends all requests, also the stops of a refused drive, with a plan's priority.
    constexpr void follow_plan() { priority_ = priority::planned; }

  protected:
    template <class Node>
    constexpr command_life(const Node& at, duration feedback, command_timeout limit)
        : read_retries_{at.read_retries}, known_{at.is_valid() ? at.address : std::uint8_t{0}, feedback},
          slot_{limit.limit()}, limits_{at.limits}, gaps_{at.gaps} {}
    ~command_life() = default;

    constexpr bool is_write() const { return modbus::is_write(request_[1]); }

    // Ends the command under way and stops all of the drive, for a fault of one motor too. `may_read`: a command
    // that reads the feedback has already succeeded.
    constexpr void stop_because(errc why, bool may_read, instant now) {
        constexpr stop_priority how = Model::stops.at_fault;
        const bool is_read = may_read && slot_.is_at(command_kind::refresh);
        if (is_read) {
            slot_.set_report({});
        } else if (!slot_.is_idle() && slot_.command().stop < how) {
            slot_.run().end(why, false);
            settle(now);
        }
        if (slot_.is_stopping()) return;
        stop(how, is_read ? owner::follow_up : owner::supervisor, steps::urgent_frames, now);
    }
    // The routine has ended.
    constexpr void settle(instant now) {
        const routine_status& r = slot_.run().result();
        if (slot_.is_setpoint_of_application()) slot_.supervisors().note_command(now);
        const bool was_stop = slot_.is_stopping();
        // A stop that does not read back was acknowledged by a late response to another write: once more.
        if (slot_.by() != owner::follow_up && was_stop && r.error() == errc::unexpected_value &&
            slot_.may_try_again())
            return begin(slot_.by(), slot_.run().urgent_left(), now);
        if (was_stop) known_.note_cause(stop_cause::command);
        if (slot_.is_setting_origin()) known_.forget_positions();
        const command_kind kind = slot_.kind();
        drop_target(slot_.command(), r.error());
        const routine done = slot_.command().steps;
        if constexpr (runs_without_line) note_end_of_motion(r, was_stop || kind == command_kind::take_over);
        const owner by = slot_.end(now);
        const bool is_judged = !r && done[r.step].what == step::kind::confirm;
        const bool moves = Model::kinds.has_motion() && Model::kinds.moves(slot_.command().then);
        slot_.command().steps = no_steps; // the model puts in what follows
        const bool is_done = static_cast<bool>(r);
        duration& watchdog = known_.link().watchdog();
        const ending e{is_done, done, r, slot_.run().words(), watchdog, limits_};
        const errc found = known_.model().learn(slot_.command(), e, known_.cached());
        if (is_done) {
            slot_.note_done(kind, found);
            conclude_command(kind, moves, was_stop, now);
        } else {
            known_.note_failure(r, is_judged);
            // A stop that goes on by other means ends as those do.
            const bool goes_on =
                !slot_.command().steps.empty() && slot_.command().stop != stop_priority::no_stop;
            if (was_stop && goes_on && by == owner::application) slot_.set_report({});
        }
        // A stop that goes on keeps the urgent frames that it has left.
        if (!slot_.command().steps.empty())
            begin(owner::follow_up, was_stop ? slot_.run().urgent_left() : steps::urgent_frames, now);
    }

    // The bytes first: short instructions of a small core reach no further.
    std::uint8_t read_retries_;
    drive_frame frame_{};
    bool is_refused_ = false;                // its bus has another drive in its place
    priority priority_ = priority::ordinary; // of all requests but stops
    knowledge<Model> known_;
    Exchange exchange_{};
    command_slot<Model> slot_;
    response_limits limits_;
    bus_gaps gaps_;
    [[no_unique_address]] unwatched_motion<!runs_without_line> unwatched_{};
    std::uint8_t request_[24]{known_.address()};
    std::uint8_t response_[held_feedback::room(image_block<Model>.words)]{};

  private:
    [[gnu::always_inline]] constexpr errc refusal_of(const prepared_command& next) const {
        const bool is_refused = is_refused_ && next.stop == stop_priority::no_stop;
        if (address() == 0 || is_refused) return errc::bad_argument;
        if (next.refusal != errc::ok)
            return next.refusal == errc::wrong_state && known_.is_faulted() ? errc::faulted : next.refusal;
        if (slot_.is_idle() || slot_.yields_to(next)) return errc::ok;
        // During a fault's stop what would move the drive, or waits for a move, is refused for the fault.
        const bool is_for_fault = slot_.by() == owner::supervisor && known_.cause() == stop_cause::fault &&
                                  Model::kinds[next.then] != command_kind::refresh;
        return is_for_fault ? errc::faulted : errc::busy;
    }
    // A move that fails is the last one all the same: the one before has no target any more. One that was refused as
    // `busy` leaves the motion under way its target.
    constexpr void drop_target(const prepared_command& c, errc why) {
        if (why == errc::ok || why == errc::busy || Model::kinds[c.then] != command_kind::move) return;
        known_.model().preempt(c);
    }
    // `stops`: a stop, or a take-over, which begins with one. A wait sends no write, and waits for a state.
    constexpr void note_end_of_motion(const routine_status& r, bool stops) {
        if (stops && r.outcome() != outcome::not_sent) unwatched_.note_stop_sent();
        bool is_at_rest = stops;
        for (const step& s : slot_.command().steps) {
            const bool is_wait = s.what == step::kind::until || s.what == step::kind::confirm;
            is_at_rest =
                is_at_rest || (is_wait && !slot_.run().has_written() && slot_.kind() == command_kind::other);
        }
        if (r && is_at_rest) unwatched_.note_rest();
    }
    // True if the command under way may have changed a setting already.
    constexpr bool leaves_unknown() const {
        const bool is_writing = frame_.is_step_sent(exchange_) && is_write();
        return slot_.changes_settings() && (slot_.run().has_written() || is_writing);
    }
    [[gnu::always_inline]] constexpr errc take(prepared_command& next, instant now) {
        const duration lost = limits_.response + gaps_.quarantine;
        if (const errc why = known_.model().admit(next, lost); why != errc::ok) return why;
        std::uint8_t urgent = next.stop != stop_priority::no_stop ? steps::urgent_frames : std::uint8_t{0};
        if (next.stop == stop_priority::no_stop && slot_.is_stopping()) {
            // A supervisor's stop: the take-over is as urgent, and if it fails the stop is repeated.
            urgent = slot_.run().urgent_left();
            slot_.keep_stop_open(frame_.is_step_sent(exchange_), now);
        }
        slot_.begin_tries();
        slot_.count_command();
        leave_command();
        slot_.command() = next;
        begin(owner::application, urgent, now);
        slot_.watch(now);
        return errc::ok;
    }
    // Another command takes the place of that under way.
    constexpr void leave_command() {
        if (slot_.is_idle() || slot_.kind() < command_kind::endless_motion) return;
        if (slot_.run().has_written() || slot_.kind() == command_kind::move)
            known_.model().preempt(slot_.command());
    }
    // Stops the drive although no command asks for it. While the drive's watchdog may have stopped it, any other
    // request may let it go on.
    [[gnu::noinline]] constexpr void stop(stop_priority how, owner by, std::uint8_t urgent, instant now) {
        const prepared_command next = Model::stop_for(how, known_.cached(), known_.link().is_expired());
        if (next.steps.empty()) return give_up_unstopped(now);
        leave_command();
        slot_.command() = next;
        begin(by, urgent, now);
    }
    // The model has no stop: the command under way ends, and nothing is known of the drive any more.
    constexpr void give_up_unstopped(instant now) {
        give_up(errc::bad_argument, now);
        known_.invalidate();
    }
    [[gnu::noinline]] constexpr void begin(owner by, std::uint8_t urgent, instant now) {
        if (frame_.is_waiting(exchange_)) {
            frame_.drop();
        } else if (frame_.purpose() == flight::step) {
            frame_.drain(is_write() && !slot_.run().is_at_stop());
        }
        slot_.begin(by, urgent, now);
        if (slot_.is_setting_origin()) known_.note_origin();
    }
    // True if a command has ended.
    template <class Line> [[gnu::always_inline]] constexpr bool check_link(instant now, const Line& on) {
        return !known_.link().holds(now, on.epoch(address())) && fail_link(now, on);
    }
    // A lost port makes the settings invalid, and so do another client that writes one of them, and the drive's
    // watchdog when its time has passed. A request without a response makes the witness due.
    template <class Line> [[gnu::noinline]] constexpr bool fail_link(instant now, const Line& on) {
        auto& link = known_.link();
        const errc why = link.take_events(on.epoch(address()), on.changed_node(), address());
        const bool is_lost = why != errc::ok;
        if (is_lost) {
            if (!slot_.is_stopping()) give_up(why, now);
            known_.invalidate();
            if (why == errc::port_lost) unwatched_.note_lost_port();
        }
        if (!link.is_expired()) {
            if (!link.is_overdue(now)) return is_lost;
            link.expire();
            known_.invalidate();
        }
        // Also in the middle of a frame: with its response the command would go on, although nothing is known.
        if (slot_.is_idle() || slot_.is_stopping() || slot_.run().is_at_stop()) return is_lost;
        give_up(errc::needs_init, now);
        return true;
    }
    constexpr bool supervise(instant now) {
        known_.polling().note_age(now);
        const auto& supervisors = slot_.supervisors();
        if (supervisors.is_stop_due(now) && slot_.is_idle()) {
            slot_.begin_tries();
            stop(supervisors.open_stop(), owner::supervisor, supervisors.urgent_left(), now);
            return true;
        }
        if constexpr (runs_without_line) {
            if (unwatched_.runs_without_port() && slot_.is_idle()) {
                const bool is_open = supervisors.is_stop_open();
                slot_.begin_tries();
                stop(is_open ? supervisors.open_stop() : stop_priority::halt, owner::supervisor,
                     steps::urgent_frames, now);
                return true;
            }
        }
        if (!slot_.has_run_out(now)) return false;
        if (!slot_.is_idle() && leaves_unknown()) known_.invalidate();
        stop(stop_priority::halt, owner::supervisor, slot_.give_up_to_supervisor(), now);
        return true;
    }
    // The command is done. `moves`: the motor that it has energised moves.
    constexpr void conclude_command(command_kind kind, bool moves, bool is_stop, instant now) {
        if (is_motion(kind)) {
            known_.note_motion(now);
            // One that was under way when the feedback showed a stop is acknowledged, and does not move.
            if (known_.is_enabled()) known_.set_cause(stop_cause::unknown);
        }
        if (known_.is_known()) known_.link().watchdog() = Model::watchdog(known_.cached());
        const bool is_take_over = kind == command_kind::take_over;
        if (kind == command_kind::setting || is_take_over) known_.drop_feedback(is_take_over);
        if (kind != command_kind::power && !is_take_over) return;
        known_.link().verify(now);
        if (!known_.is_enabled() || is_stop) return;
        slot_.note_enabled(moves, now);
        known_.set_cause(stop_cause::unknown);
    }
};

} // namespace servobus::detail
