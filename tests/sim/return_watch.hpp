// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive whose cached state is invalid: its motor begins no motion until the program has initialised it
// again (G20, G21, S3, S5). Judged by the motion that the simulated drive is commanded to do and the
// requests that were sent to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "facade.hpp"

namespace trial {

class return_watch {
  public:
    return_watch(const scene& on, facade& of) : on_{&on}, of_{&of}, motion_{of.motion()} {}

    /// The cached state of the drive is invalid from now on.
    void lose(const char* why) {
        why_ = why;
        needs_ = need::an_init;
        has_heard_stop_ = false;
        is_known_to_program_ = true;
    }
    /// The drive was restarted. A host that lost no more than it may read again cannot know: the command in
    /// progress may go on. The next one may begin only if the drive does not show its restart.
    void restarted() {
        if (needs_ == need::an_init) return;
        why_ = "a restart";
        needs_ = need::a_command;
        is_known_to_program_ = false;
    }
    /// The program has given a command.
    void ordered() {
        const errand& wanted = of_->wanted();
        is_taking_over_ = wanted.is_init;
        // The frame on the wire belongs to the command before, and its rest still leaves.
        may_move_ = wanted.moves || wanted.enables || (may_move_ && on_->is_awaited);
        is_of_command_before_ = !(wanted.moves || wanted.enables);
        is_under_way_ = true;
        has_heard_stop_ = false;
        if (needs_ == need::a_command && !is_taking_over_ && !wanted.is_stop)
            needs_ = of_->shows_restarts() ? need::an_init : need::nothing;
    }

    /// A request to the drive begins to leave.
    void begins(servobus::bytes frame) {
        is_late_unseen_ = on_->was_stalled_unseen;
        if (!of_->is_stopped_by_watchdog()) asked_at_ = on_->now();
        if (is_of_command_before_) may_move_ = false;
        check_write(frame);
        if (!of_->place().device().is_off()) return unanswered_.clear();
        if (servobus::modbus::is_write(frame[1])) {
            if (!of_->is_stop(frame) && !of_->is_setpoint(frame)) lose("a write that the drive missed");
        } else if (++unanswered_[{frame.begin(), frame.end()}] >= tries_of_a_read && !of_->has_witness()) {
            lose("reads without a response");
        }
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        of_->note_turn(on_->now());
        follow();
        look_at_motion();
        if (!of_->is_idle()) return;
        is_under_way_ = false;
        of_->end_take_over();
    }

    /// The program knows that the drive must be initialised first.
    bool must_be_initialised() const { return needs_ == need::an_init && is_known_to_program_; }

  private:
    enum class need : std::uint8_t { nothing, a_command, an_init };

    // After so many reads without a response a bus and a facade invalidate the cached state.
    static constexpr unsigned tries_of_a_read = 3;
    // Three frames of a stop, each with its tries.
    static constexpr std::uint64_t longest_stop_us = 10'000'000;

    void look_at_motion() {
        if (of_->is_stopped_by_watchdog()) {
            // By a clock that has jumped back since the last request the time may not have passed.
            if (on_->jumped_back_at <= asked_at_) lose("the stop of its watchdog");
            is_stopped_ = true;
            stopped_motion_ = of_->resumed_motion(); // also a motion commanded in the same stall
        }
        const std::uint64_t motion = of_->motion();
        if (motion == motion_) return;
        // A program whose clock is stopped cannot notice that the watchdog time has passed. Neither can one
        // that stalls between its look at the clock and the frame.
        if (motion != 0 && (on_->is_clock_still || is_late_unseen_)) needs_ = need::nothing;
        if (motion != 0 && is_begun_by_itself(motion))
            throw broken{"G21: after " + std::string{why_} + " node " +
                         std::to_string(of_->place().address()) + " moves, but has not been initialised"};
        if (motion == 0) stopped_motion_ = is_stopped_ ? of_->resumed_motion() : motion_;
        if (!goes_on_with_stop(motion)) motion_ = motion;
    }
    // G21, by the wire: only an initialisation writes anything but a stop.
    void check_write(servobus::bytes frame) const {
        if (!must_be_initialised() || is_taking_over_ || !servobus::modbus::is_write(frame[1])) return;
        if (of_->is_stop(frame) || on_->is_clock_still || on_->does_clock_lie || is_late_unseen_) return;
        throw broken{"G21: after " + std::string{why_} + " node " + std::to_string(of_->place().address()) +
                     " gets a write, but has not been initialised"};
    }

    bool is_begun_by_itself(std::uint64_t motion) const {
        if (needs_ == need::a_command) return !is_under_way_ || !may_move_;
        return needs_ == need::an_init && !goes_on_with_stop(motion);
    }
    // S3: the first frame after a stop by the watchdog is a stop, though it may not stop the drive in every
    // mode. The motion that resumes with it must have stopped when that command ends. If the drive has received nothing
    // but stops since, the command has ended without confirmation, and the watchdog ends the motion.
    bool goes_on_with_stop(std::uint64_t motion) const {
        const bool is_short = on_->now() - on_->stalled_us - let_go_at_ < longest_stop_us;
        return needs_ == need::an_init && is_let_go_by_stop_ && is_short &&
               (!of_->is_idle() || !has_heard_more_) && motion == stopped_motion_;
    }

    // Checks what the drive has executed: an initialisation is complete once it has stopped the drive and
    // read it.
    void follow() {
        const bool was_taking_over = is_taking_over_;
        if (of_->is_idle()) is_taking_over_ = false; // it was reported to have ended
        const std::vector<execution>& all = of_->place().executed();
        auto next = all.end();
        while (next != all.begin() && std::prev(next)->transaction > seen_) --next;
        for (; next != all.end(); ++next) {
            const execution& e = *next;
            seen_ = e.transaction;
            const bool is_stop = e.is_write && of_->is_stop(frame_of(e));
            if (is_stopped_) {
                is_let_go_by_stop_ = is_stop;
                let_go_at_ = on_->now() - on_->stalled_us;
            }
            has_heard_more_ = !is_stop || (has_heard_more_ && !is_stopped_);
            is_stopped_ = false;
            if (!was_taking_over || e.refusal != 0) continue;
            if (!e.is_write && has_heard_stop_) needs_ = need::nothing;
            has_heard_stop_ = has_heard_stop_ || is_stop;
        }
    }
    byte_list frame_of(const execution& e) const {
        const auto high = [](std::size_t word) { return static_cast<std::uint8_t>(word >> 8); };
        const auto low = [](std::size_t word) { return static_cast<std::uint8_t>(word & 0xFFu); };
        byte_list f{of_->place().address(), 0x10,
                    high(e.address),        low(e.address),
                    high(e.words.size()),   low(e.words.size()),
                    low(2 * e.words.size())};
        for (const std::uint16_t w : e.words) f.insert(f.end(), {high(w), low(w)});
        return f;
    }

    const scene* on_;
    facade* of_;
    std::map<byte_list, unsigned> unanswered_; ///< consecutive reads without a response
    const char* why_ = "";
    std::uint64_t motion_ = 0;
    std::uint64_t stopped_motion_ = 0; ///< the motion before standstill
    std::uint64_t seen_ = 0;           ///< the last execution
    std::uint64_t let_go_at_ = 0;      ///< without the stalls before
    std::uint64_t asked_at_ = 0;       ///< when the last request before its stop began to leave
    need needs_ = need::nothing;
    bool is_known_to_program_ = false;  ///< why it needs an initialisation
    bool is_under_way_ = false;         ///< a command has not been reported to have ended
    bool may_move_ = false;             ///< it may begin a motion
    bool is_of_command_before_ = false; ///< `may_move_`, up to the next frame
    bool is_stopped_ = false;           ///< by its watchdog, and has received nothing since
    bool is_let_go_by_stop_ = false;    ///< the first request after that was a stop
    bool has_heard_more_ = false;       ///< and since then also requests that are no stops
    bool is_late_unseen_ = false;       ///< a stall that the program cannot know of delayed its last request
    bool is_taking_over_ = false;       ///< an initialisation is in progress
    bool has_heard_stop_ = false;       ///< the drive has received a stop since the last command
};

} // namespace trial
