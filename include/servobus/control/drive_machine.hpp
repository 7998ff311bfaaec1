// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The machine of a drive: a state machine that chooses the drive's next frame and concludes what its end means. It is
// given the time, waits for nothing and touches no hardware. A facade moves its frames over a line; a test does so by
// hand, here on a line that answers at once. control/README.md draws it.
//
//     template <class Machine, class Line> void turn(Machine& drive, Line& on, instant now) {
//         if (drive.pass(now, on)) drive.notify(on);
//         drive.load(drive.next(now, on), now, on);
//         if (drive.purpose() != flight::none) on.answer(drive.exchange()), drive.conclude(now, now, false);
//     }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/detail/begin_rules.hpp>
#include <servobus/control/detail/command_end.hpp>
#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/drive_frame.hpp>
#include <servobus/control/detail/feedback_end.hpp>
#include <servobus/control/detail/frame_buffers.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/detail/next_frame.hpp>
#include <servobus/control/detail/terms.hpp>
#include <servobus/control/detail/verdict_rules.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervised_node.hpp>
#include <servobus/control/supervision.hpp>

namespace servobus {

/// The machine of a drive that `Model` describes (device/README.md). `Exchange` is the exchange of its line. A `Line`
/// gives the epoch of a node, the node that was changed last, and the timing. It gives an exchange up (`abandon`) and
/// keeps itself free (`announce_stop`).
template <class Model, class Exchange> class drive_machine {
  public:
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;

    template <class Node>
    constexpr drive_machine(const Node& at, duration feedback, command_timeout limit)
        : known_{at.is_valid() ? at.address : std::uint8_t{0}, feedback}, terms_{at, limit.is_by_plan()},
          slot_{limit.limit()}, buffers_{known_.address()} {}

    constexpr std::uint8_t address() const { return known_.address(); }
    constexpr const detail::knowledge<Model>& known() const { return known_; }
    /// For what only a drive's own facade knows, such as the geometry of an axis.
    constexpr Model& model() { return known_.model(); }
    constexpr const detail::command_slot<Model>& slot() const { return slot_; }
    constexpr detail::supervisors& supervisors() { return slot_.supervisors(); }
    constexpr detail::terms& terms() { return terms_; }
    constexpr const detail::terms& terms() const { return terms_; }

    // --- Its command

    /// True if the settings are known and the link has held until now.
    constexpr bool is_known(instant now, epoch at) const {
        return known_.is_known() && known_.link().holds(now, at);
    }
    /// The settings, unknown ones if they hold no more. It checks the link, which may end the command under way.
    template <class Line> constexpr const settings& valid_settings(instant now, const Line& on) {
        (void)check_link(now, on);
        if (known_.link().is_expired()) known_.invalidate();
        return known_.cached();
    }
    /// Starts a command that was planned with `valid_settings`.
    constexpr errc accept(prepared_command& next, instant now) {
        const bool is_refused = terms_.is_refused() && next.stop == stop_priority::no_stop;
        if (address() == 0 || is_refused) return errc::bad_argument;
        if (const errc refusal = detail::refusal_of(next, known_, slot_); refusal != errc::ok) {
            detail::drop_target(known_, next, refusal);
            return refusal;
        }
        if (!slot_.is_idle() && leaves_unknown()) {
            known_.invalidate();
            // The stop was planned from settings that are not known any more.
            if (next.stop != stop_priority::no_stop)
                next = Model::stop_for(next.stop, known_.cached(), false);
        }
        if (next.steps.empty()) return errc::bad_argument; // `no_steps` without a reason
        return take(next, now);
    }
    /// The refusal becomes the report, unless a command is under way. Returns it.
    constexpr errc note_refusal(errc refusal) {
        if (refusal != errc::ok && slot_.is_idle()) slot_.set_report(refusal);
        return refusal;
    }
    /// Ends the command under way with an error, and drops its frame: `notify` abandons it, also on the wire.
    constexpr void give_up(errc why, instant now) {
        if (slot_.is_idle()) return;
        const bool was_written = frame_.is_step_sent(exchange()) && buffers_.is_write();
        frame_.drop();
        run().end(why, was_written);
        settle(now);
    }
    /// The line was told of a change of settings that this machine's own command makes.
    constexpr void note_own_change() { known_.link().skip_change(); }
    /// Time passes: the link is checked, and a supervisor may begin a stop. True if a command has ended or begun.
    template <class Line> constexpr bool pass(instant now, const Line& on) {
        const bool has_ended = check_link(now, on);
        return supervise(now) || has_ended;
    }
    /// Adopts what a plan states for the drive.
    constexpr void adopt(const supervised_node& as, duration stop_every, duration retry_every,
                         duration longest_response, instant now) {
        terms_.adopt(as.limits, as.gaps, longest_response);
        known_.polling().set_period(as.by.feedback);
        known_.polling().absence().set_period(retry_every);
        supervisors().set_limit(as.by.command_timeout.limit(), now);
        supervisors().repeat_stops(stop_every);
    }
    /// A plan has another drive in its place: it is polled no more and refuses all commands but stops.
    constexpr void refuse() {
        terms_.refuse();
        known_.polling().set_period({});
    }

    // --- Its frame

    /// The purpose of the frame that waits for the line or is on it.
    constexpr flight purpose() const { return frame_.purpose(); }
    constexpr Exchange& exchange() { return exchange_; }
    /// True from the frame's first byte until `conclude`.
    constexpr bool is_on_the_wire() const { return frame_.is_on_the_wire(exchange_); }
    /// True if an urgent stop is the next frame, and no frame of the drive is on the wire.
    constexpr bool wants_stop() const { return slot_.run().is_urgent() && !is_on_the_wire(); }
    /// True if the line is to keep itself free for a stop, which is the next frame.
    constexpr bool announces_stop() const { return slot_.run().is_urgent() && purpose() != flight::step; }
    /// Makes the line follow a command that has begun or ended: gives up a dropped frame, announces a stop.
    template <class Line> constexpr void notify(Line& on) {
        if (frame_.is_dropped(exchange())) on.abandon(exchange());
        if (announces_stop()) on.announce_stop();
    }
    /// The waiting frame's place in the line's queue: a lower one has waited longer. 0: no frame waits.
    constexpr std::uint16_t ticket() const {
        return frame_.is_waiting(exchange_) ? exchange_.ticket() : std::uint16_t{0};
    }
    /// The purpose of the frame to send, as long as none is on the wire.
    template <class Line> constexpr flight next(instant now, const Line& on) const {
        return detail::next_frame(known_, slot_, now, on);
    }
    /// Fills the exchange with the request for `what`; forgets the frame if that is `none`. The exchange has ended, or
    /// waited and was abandoned.
    template <class Line> [[gnu::noinline]] constexpr void load(flight what, instant now, const Line& on) {
        const bool has_waited = purpose() != flight::none;
        frame_.begin(what, on.epoch(address()));
        if (what == flight::none) return;
        const std::uint16_t ticket = has_waited ? exchange().ticket() : std::uint16_t{0};
        buffers_.fill(exchange_, what, known_, slot_, terms_, now, on);
        exchange().set_ticket(ticket); // it keeps its place in the queue
    }
    /// Concludes from an exchange that is done. `began`: when its first byte left. `is_echo_possible`: the response may
    /// be the request's echo.
    constexpr void conclude(instant now, instant began, bool is_echo_possible) {
        const status got = exchange().status();
        const flight was = frame_.end();
        known_.note_frame(got.has_response(), exchange().was_sent(),
                          was == flight::refresh || was == flight::witness, began, now);
        switch (was) {
        case flight::step: conclude_step(got, now); break;
        case flight::refresh:
            if (detail::take_read(known_, slot_, exchange_, buffers_.held(), terms_, began, now))
                conclude_image(exchange().words(), false, now);
            break;
        case flight::witness: conclude_witness(got, now); break;
        case flight::drained_write:
            if (!got.has_response()) known_.invalidate();
            known_.unwatched().note_sent(); // perhaps its routine moves
            [[fallthrough]];
        case flight::drained: known_.set_last_frame(last_frame::other); break;
        case flight::none: break;
        }
        if (slot_.is_idle() || !run().is_over()) return;
        if (is_echo_possible) run().note_possible_echo();
        settle(now);
        // The image that a stop or a change of settings has read is judged when that has ended.
        if (known_.last_frame() == last_frame::feedback && known_.feedback().has_image())
            react(detail::judged(known_, slot_, known_.feedback().image()), now);
    }

  private:
    constexpr detail::routine_run& run() { return slot_.run(); }

    // --- Commands begin and end

    // True if the command under way may have changed a setting already.
    constexpr bool leaves_unknown() const {
        const bool is_writing = frame_.is_step_sent(exchange_) && buffers_.is_write();
        return slot_.changes_settings() && (slot_.run().has_written() || is_writing);
    }
    [[gnu::always_inline]] constexpr errc take(prepared_command& next, instant now) {
        if (const errc why = known_.model().admit(next, terms_.lost_response()); why != errc::ok) return why;
        std::uint8_t urgent = next.stop != stop_priority::no_stop ? steps::urgent_frames : std::uint8_t{0};
        if (next.stop == stop_priority::no_stop && slot_.is_stopping())
            urgent = slot_.keep_stop_open(frame_.is_step_sent(exchange()), now);
        slot_.count_command();
        replace_by(next, owner::application, urgent, now);
        slot_.watch(now);
        return errc::ok;
    }
    // Puts a command in place of what is under way. A move that it replaces has no target any more.
    constexpr void replace_by(const prepared_command& next, owner by, std::uint8_t urgent, instant now) {
        const bool is_motion = !slot_.is_idle() && slot_.kind() >= command_kind::endless_motion;
        if (is_motion && (run().has_written() || slot_.kind() == command_kind::move))
            known_.model().preempt(slot_.command());
        slot_.command() = next;
        begin(by, urgent, now);
    }
    [[gnu::noinline]] constexpr void begin(owner by, std::uint8_t urgent, instant now) {
        if (frame_.is_waiting(exchange())) {
            frame_.drop();
        } else if (frame_.purpose() == flight::step) {
            frame_.drain(buffers_.is_write() && !run().is_at_repeatable_step());
        }
        slot_.begin(by, urgent, now);
        if (slot_.is_setting_origin()) known_.feedback().note_origin();
    }
    // The routine has ended: so has its command, or steps follow.
    [[gnu::noinline]] constexpr void settle(instant now) {
        if (slot_.is_setpoint_of_application()) slot_.supervisors().note_command(now);
        if (slot_.is_to_be_tried_again()) return begin(slot_.by(), run().urgent_left(), now);
        const bool was_stop = slot_.is_stopping();
        detail::command_end<Model>{known_, slot_}.conclude(terms_.limits(), frame_.misses_when_loaded(), now);
        // A stop that goes on keeps the urgent frames that it has left.
        if (!slot_.command().steps.empty())
            begin(owner::follow_up, was_stop ? run().urgent_left() : steps::urgent_frames, now);
    }

    // --- Stops that no command asks for

    // After the watchdog's time the first frame is a stop: any other request may let the drive run on.
    [[gnu::noinline]] constexpr void stop(stop_priority how, owner by, std::uint8_t urgent, instant now) {
        const prepared_command next = Model::stop_for(how, known_.cached(), known_.link().is_expired());
        if (next.steps.empty()) { // the model has none
            give_up(errc::bad_argument, now);
            return known_.invalidate();
        }
        replace_by(next, by, urgent, now);
    }
    // Stops all of the drive, for a fault of one motor too. `may_read`: a command that reads the feedback is done.
    constexpr void stop_because(errc why, bool may_read, instant now) {
        constexpr stop_priority how = Model::stops.at_fault;
        const bool is_read = may_read && slot_.is_at(command_kind::refresh);
        if (is_read) {
            slot_.set_report({});
        } else if (!slot_.is_idle() && slot_.command().stop < how) {
            run().end(why, false);
            settle(now);
        }
        if (slot_.is_stopping()) return;
        stop(how, is_read ? owner::follow_up : owner::supervisor, steps::urgent_frames, now);
    }
    constexpr bool supervise(instant now) {
        known_.polling().note_age(now);
        const detail::due_stop due = slot_.due_stop_at(now, known_.unwatched().runs_without_port());
        if (due.how == stop_priority::no_stop) return false;
        if (due.is_of_command_timeout && !slot_.is_idle() && leaves_unknown()) known_.invalidate();
        stop(due.how, owner::supervisor, due.urgent, now);
        return true;
    }

    // --- The link: each call returns true if a command has ended, or the settings were lost

    template <class Line> [[gnu::always_inline]] constexpr bool check_link(instant now, const Line& on) {
        return !known_.link().holds(now, on.epoch(address())) && fail_link(now, on);
    }
    // A lost port, a write of another client and the end of the watchdog's time make the settings invalid.
    template <class Line> [[gnu::noinline]] constexpr bool fail_link(instant now, const Line& on) {
        auto& link = known_.link();
        const errc why = link.take_events(on.epoch(address()), on.changed_node(), address());
        const bool is_lost = why != errc::ok;
        if (is_lost) {
            if (!slot_.is_stopping()) give_up(why, now);
            known_.invalidate();
            if (why == errc::port_lost) known_.unwatched().note_lost_port();
        }
        if (link.expires(now)) known_.invalidate();
        if (!link.is_expired()) return is_lost;
        // Once the drive has missed a part of a stop, a read might let it go on. Any other command ends even during a
        // frame: with its response it would go on, although nothing is known.
        const bool is_stop = slot_.is_stopping();
        const bool goes_on = is_stop && (!run().has_missed_stop() || is_on_the_wire());
        if (slot_.is_idle() || run().is_at_repeatable_step() || goes_on) return is_lost;
        give_up(is_stop ? detail::routine_run::error_of_missed_stop : errc::needs_init, now);
        return true;
    }

    // --- What a frame's end means

    constexpr void conclude_step(const status& got, instant now) {
        run().conclude(exchange(), terms_, now);
        if (run().is_waiting() && !known_.feedback().held().is_any()) known_.polling().note_wait(now);
        const bool is_write = buffers_.is_write();
        const bool is_motion = detail::is_motion(slot_.kind()) || Model::kinds.moves(slot_.command().then);
        if (is_motion && is_write && exchange().was_sent()) known_.unwatched().note_sent();
        known_.set_last_frame(is_write ? last_frame::other : last_frame::step_read);
        if (is_write && got.error() == errc::ok && detail::is_motion(slot_.kind()))
            known_.motion().note_motion(now); // the last write is the start
    }

    constexpr void react(verdict found, instant now) {
        const errc why = detail::note_verdict(found, known_, slot_);
        if (why != errc::ok) stop_because(why, true, now);
    }
    // `is_verified`: the image was held back until the witness was read.
    constexpr void conclude_image(words_view read, bool is_verified, instant now) {
        std::uint16_t words[image_block<Model>.words]; // NOLINT: all are filled
        for (std::size_t i = 0; i < image_block<Model>.words; ++i) words[i] = read[i];
        verdict found = verdict::as_expected;
        if (detail::is_held_back(known_, slot_, words, is_verified, found)) {
            known_.feedback().held().hold_image(buffers_.held(), exchange().response());
            return known_.link().require_check();
        }
        known_.take_image(words, now);
        known_.set_last_frame(last_frame::feedback);
        react(found, now);
        detail::use_image(known_, slot_, buffers_.held(), now);
    }
    constexpr void conclude_witness(const status& got, instant now) {
        if (!detail::take_witness(known_, slot_, terms_, got, now)) return;
        if (known_.is_same(exchange().words(), slot_.command())) {
            known_.link().verify(frame_.misses_when_loaded(), now);
            known_.take_held_block(buffers_.held());
            if (known_.feedback().held().is_image()) {
                const words_view words = known_.feedback().held().words(buffers_.held());
                known_.feedback().held().drop();
                conclude_image(words, true, now);
            }
            if (!slot_.is_idle()) run().conclude_witness(now);
            return;
        }
        detail::note_restart(known_, slot_);
        if constexpr (Model::stops.after_restart) return stop_because(errc::needs_init, false, now);
        if (!slot_.is_idle() && !slot_.is_stopping()) run().end(errc::needs_init, false);
    }

    // The bytes first: short instructions of a small core reach no further.
    detail::drive_frame frame_{};
    detail::knowledge<Model> known_;
    Exchange exchange_{};
    detail::terms terms_;
    detail::command_slot<Model> slot_;
    detail::frame_buffers<Model, Exchange> buffers_;
};

} // namespace servobus
