// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What an application is told of a drive that meets faults, wired stops and restarts: a move is said to have reached
// its target only where it is (G34), an inability shows in the first feedback after it (G35), and nothing is enabled
// or started that was not commanded (S1, S2, S3). What the facade reports is judged; the judgement follows from the
// requests on the wire and the simulated drive.
#pragma once

#include <cstdint>
#include <string>

#include "facade.hpp"

namespace trial {

class truth_watch {
  public:
    truth_watch(const scene& on, facade& of) : on_{&on}, of_{&of} {}

    /// A fault or an input acts on the drive now.
    void suffers() { is_suffering_ = true; }
    /// The drive restarts and responds from `up_at` on.
    void restarted(std::uint64_t up_at) {
        was_restarted_ = true;
        is_shown_ = is_held_back_ = false; // what was read before is not true any more
        is_stopping_ = is_unable_ && !of_->is_idle();
        up_at_ = up_at;
        reads_since_restart_ = 0;
    }

    /// The program has given a command.
    void ordered() {
        const errand& wanted = of_->wanted();
        if (is_under_way_) of_->note_end(false); // it was preempted
        is_under_way_ = true;
        is_first_of_init_ = wanted.is_init;
        began_unable_ = is_unable_ && since(unable_at_) > longest_to_show_us();
        if (wanted.enables || wanted.is_init) was_restarted_ = false;
        // The rest of a request that is leaving may still enable or start.
        if (wanted.enables) {
            enables_left_ = 1;
        } else if (!on_->is_awaited) {
            enables_left_ = 0;
        }
        if (wanted.moves) {
            starts_left_ = 1;
        } else if (!on_->is_awaited) {
            starts_left_ = 0;
        }
    }

    /// A request begins to leave.
    void begins(servobus::bytes frame) {
        const errand& wanted = of_->wanted();
        const bool is_stop = of_->is_stop(frame);
        if (is_first_of_init_ && !is_stop) throw broken{"S1: the first request of an init is no stop"};
        // An init that waited to send begins after a restart that came meanwhile.
        if (is_first_of_init_ && on_->now() > up_at_) was_restarted_ = false;
        is_first_of_init_ = false;
        if (of_->is_enable(frame) && !wanted.enables)
            throw broken{"S1: " + wanted.name + " sends an enable, which was not commanded"};
        if (of_->is_start(frame)) {
            if (!wanted.moves) throw broken{"S1: " + wanted.name + " sends a start, which was not commanded"};
            of_->note_start();
        }
        const bool can_know = !on_->was_stalled_unseen && !on_->is_clock_still && !on_->does_clock_lie;
        if (needs_stop_ && !is_stop && can_know)
            throw broken{"S3: the first request after the stop by the drive's watchdog is no stop"};
        needs_stop_ = false;
        // Wheels that were given a speed just before are read at rest before they turn.
        const bool was_set_going = set_going_at_ != 0 && since(set_going_at_) < 300'000;
        if (of_->changes_mode(frame) && !of_->stands() && !was_set_going)
            throw broken{"S3: the mode is changed while the motor turns"};
        is_asked_while_unable_ =
            of_->is_feedback(frame) && is_suffering_ && !of_->is_able() && of_->shows_plight();
        is_asked_after_restart_ = of_->is_feedback(frame) && was_restarted_ && on_->now() > up_at_;
    }
    /// That request has got a valid response.
    void answered(servobus::bytes frame) {
        // After a restart a reading may be held back until the next frame, the witness (G39).
        is_shown_ = is_shown_ || is_held_back_;
        if (!of_->is_feedback(frame)) return;
        if (is_asked_while_unable_) (was_restarted_ ? is_held_back_ : is_shown_) = true;
        if (is_asked_after_restart_ && ++reads_since_restart_ == 1) first_read_ = clock();
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        look_at_starts();
        look_at_ability();
        const bool is_stopped = of_->is_stopped_by_watchdog();
        needs_stop_ = is_stopped && (needs_stop_ || !was_stopped_);
        was_stopped_ = is_stopped;
        const bool is_moved = is_under_way_ && of_->wanted().moves;
        if (!is_moved && of_->has_goal() && of_->says_reached() && !of_->is_at_goal() && !is_restart_hidden())
            throw broken{"G34: the move is said to have reached its target, but the motor is elsewhere"};
    }

    /// An input keeps the drive stopped, and by the reading of the manual no register that the facade reads shows it.
    bool is_plight_hidden() const { return is_unable_ && !of_->shows_plight(); }

    /// The command of the program was reported to have ended.
    void ended() {
        const errand& wanted = of_->wanted();
        const bool is_done = static_cast<bool>(of_->last());
        is_under_way_ = false;
        if (wanted.moves) set_going_at_ = clock();
        if (is_done && wanted.has_arrived) {
            ++on_->count->arrivals;
            if (!wanted.has_arrived() && !is_restart_hidden())
                throw broken{"G34: " + wanted.name +
                             " is reported done, but the move has not ended at its target"};
        }
        if (is_done && wanted.moves && began_unable_ && is_unable_ && !on_->is_struck && of_->shows_plight())
            throw broken{"G35: " + wanted.name +
                         " is reported done by a drive that is faulted or has no power"};
        of_->note_end(is_done);
    }

  private:
    // A restart shows within half a second, a feedback period and two frames; several readings tell more than one
    // that was the first after a pause.
    static constexpr std::uint64_t restart_shows_us = 700'000;
    static constexpr unsigned readings_after_restart = 5;

    std::uint64_t clock() const { return on_->now() - on_->stalled_us; }
    std::uint64_t since(std::uint64_t at) const { return clock() - at; }
    std::uint64_t longest_to_show_us() const {
        return servobus::default_feedback.us +
               2u * (std::uint64_t{of_->place().limits().response.us} + on_->wire_time(64));
    }
    // No register of the drive shows that it was restarted.
    bool is_restart_hidden() const { return was_restarted_ && !of_->shows_restart_while_enabled(); }
    // What the drive does is not known meanwhile.
    bool is_in_transition() const {
        const errand& wanted = of_->wanted();
        return is_under_way_ && (wanted.is_init || wanted.is_stop || wanted.enables || wanted.disables);
    }

    void look_at_ability() {
        const bool is_able = of_->is_able();
        if (is_able || !is_suffering_) {
            is_suffering_ = is_suffering_ && !is_unable_;
            is_unable_ = is_shown_ = is_held_back_ = is_asked_while_unable_ = began_unable_ = false;
        } else if (!is_unable_) {
            is_unable_ = true;
            unable_at_ = clock();
            ++on_->count->plights;
        }
        if (is_in_transition()) is_shown_ = is_held_back_ = is_asked_while_unable_ = false;
        if (is_able || is_in_transition()) reads_since_restart_ = 0;
        is_stopping_ = is_stopping_ && !of_->is_idle();
        if (!of_->says_enabled()) return;
        // A stop by the facade itself is judged by what it has read, as it ends.
        const bool stops_by_itself = is_stopping_ || (!is_under_way_ && !of_->is_idle());
        if (is_shown_ && !stops_by_itself)
            throw broken{"G35: the drive is faulted or has no power, and the feedback after that has been "
                         "read, but the "
                         "facade says that it is enabled"};
        if (was_restarted_ && !is_able && of_->shows_restart_while_enabled() &&
            reads_since_restart_ >= readings_after_restart && since(first_read_) > restart_shows_us)
            throw broken{
                "G35: the drive has restarted and is off, and its feedback has been read for 0.7 s, but the "
                "facade says that it is enabled"};
    }
    void look_at_starts() {
        const std::uint32_t enables = of_->enables() - enables_;
        const std::uint32_t starts = of_->starts() - starts_;
        enables_ += enables;
        starts_ += starts;
        // Between a look at its inputs and their write a drive may restart, and the write enables it (S5).
        const bool may_enable = was_restarted_ && of_->is_enabled_by_level();
        if (enables > enables_left_ && !may_enable)
            throw broken{"S1: the drive was enabled during " + of_->wanted().name +
                         ", which was not commanded"};
        if (starts > starts_left_)
            throw broken{"S1: a move was started during " + of_->wanted().name + ", which was not commanded"};
        enables_left_ -= enables > enables_left_ ? enables_left_ : enables;
        starts_left_ -= starts;
        if (enables != 0 && of_->motion() != 0 && of_->has_targets())
            throw broken{"S2: the drive was enabled while a target was not zero"};
    }

    const scene* on_;
    facade* of_;
    std::uint64_t unable_at_ = 0;    ///< as all times here, without the stalls before
    std::uint64_t set_going_at_ = 0; ///< the end of a command that moves; 0 if there was none
    std::uint64_t first_read_ = 0;   ///< of the feedback since the restart
    std::uint64_t up_at_ = 0;        ///< with the stalls
    std::uint32_t enables_ = 0;
    std::uint32_t starts_ = 0;
    std::uint32_t enables_left_ = 0;
    std::uint32_t starts_left_ = 0;
    unsigned reads_since_restart_ = 0;
    bool is_under_way_ = false;     ///< a command has not been reported to have ended
    bool is_first_of_init_ = false; ///< the next request is the first of an initialisation
    bool is_stopping_ = false;      ///< it restarted while a fault stopped it: the end of the stop shows that
    bool is_suffering_ = false;     ///< a fault or an input has acted on the drive
    bool is_unable_ = false;        ///< because of that it has no power
    bool is_shown_ = false;         ///< the feedback after that was read
    bool is_held_back_ = false;     ///< it was read, but may wait for the next frame
    bool is_asked_while_unable_ = false;  ///< by the last request
    bool is_asked_after_restart_ = false; ///< likewise
    bool began_unable_ = false;           ///< the command, longer after that than it takes to show
    bool needs_stop_ = false;    ///< its watchdog has stopped the drive, and it was sent nothing since
    bool was_stopped_ = false;   ///< by its watchdog
    bool was_restarted_ = false; ///< since the last initialisation or enable
};

} // namespace trial
