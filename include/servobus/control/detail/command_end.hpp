// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The end of a command: what it changes of the knowledge of the drive, and of the supervisors.
#pragma once

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/response_limits.hpp>

namespace servobus::detail {

/// A move that fails is the last one all the same, so the one before has no target any more. A move that was refused as
/// `busy` leaves the motion under way its target.
template <class Model>
constexpr void drop_target(knowledge<Model>& known, const typename Model::prepared_command& c, errc why) {
    if (why == errc::ok || why == errc::busy || Model::kinds[c.then] != command_kind::move) return;
    known.model().preempt(c);
}

template <class Model> class command_end {
  public:
    constexpr command_end(knowledge<Model>& known, command_slot<Model>& slot) : known_{known}, slot_{slot} {}

    /// Ends the command, and puts the steps that follow into it; none if nothing follows.
    [[gnu::always_inline]] constexpr void conclude(response_limits& limits, std::uint16_t misses_when_loaded,
                                                   instant now) {
        const command_status& r = slot_.run().result();
        const bool was_stop = slot_.is_stopping();
        if (was_stop) known_.motion().note_cause(stop_cause::command);
        if (slot_.is_setting_origin()) known_.feedback().forget_positions();
        const command_kind kind = slot_.kind();
        drop_target(known_, slot_.command(), r.error());
        const routine done = slot_.command().steps;
        if constexpr (!polling<Model>::has_watchdog)
            note_end_of_motion(r, was_stop || kind == command_kind::take_over);
        const owner by = slot_.end(now);
        const bool is_judged = !r && done[r.step()].asks_model();
        const bool moves = Model::kinds.has_motion() && Model::kinds.moves(slot_.command().then);
        slot_.command().steps = no_steps; // the model puts in what follows
        const bool is_done = static_cast<bool>(r);
        duration& watchdog = known_.link().watchdog();
        const ending e{is_done, done, r, slot_.run().words(), watchdog, limits};
        const errc found = known_.model().learn(slot_.command(), e, known_.cached());
        if (is_done) {
            slot_.note_done(kind, found);
            note_success(kind, moves, was_stop, misses_when_loaded, now);
        } else {
            known_.note_failure(r, is_judged);
            // If the model lets a stop go on by other steps, their end is the report.
            const bool goes_on =
                !slot_.command().steps.empty() && slot_.command().stop != stop_priority::no_stop;
            if (was_stop && goes_on && by == owner::application) slot_.set_report({});
        }
    }

  private:
    // `moves`: the motor that the command has energised moves.
    constexpr void note_success(command_kind kind, bool moves, bool is_stop, std::uint16_t misses,
                                instant now) {
        if (is_motion(kind)) {
            known_.motion().note_motion(now);
            // If the feedback has shown a stop since the motion began, it does not move: the cause stays.
            if (known_.is_enabled()) known_.motion().set_cause(stop_cause::unknown);
        }
        if (known_.is_known()) known_.link().watchdog() = Model::watchdog(known_.cached());
        const bool is_take_over = kind == command_kind::take_over;
        if (kind == command_kind::setting || is_take_over) known_.feedback().make_old(is_take_over);
        if (kind != command_kind::power && !is_take_over) return;
        known_.link().verify(misses, now);
        if (!known_.is_enabled() || is_stop) return;
        slot_.note_enabled(moves, now);
        known_.motion().set_cause(stop_cause::unknown);
    }
    // `stops`: a stop, or a take-over, which begins with one. A wait sends no write, and waits for a state.
    constexpr void note_end_of_motion(const command_status& r, bool stops) {
        if (stops && r.outcome() != outcome::not_sent) known_.unwatched().note_stop_sent();
        bool is_at_rest = stops;
        for (const step& s : slot_.command().steps) {
            const bool is_wait = s.what == step::kind::until || s.what == step::kind::confirm;
            is_at_rest =
                is_at_rest || (is_wait && !slot_.run().has_written() && slot_.kind() == command_kind::other);
        }
        if (r && is_at_rest) known_.unwatched().note_rest();
    }

    knowledge<Model>& known_;
    command_slot<Model>& slot_;
};

} // namespace servobus::detail
