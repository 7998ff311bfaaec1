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
    return_watch(const scene& on, facade& of) : on_{&on}, of_{&of} {}

    /// The cached state of the drive is invalid from now on.
    void lose(const char* why) {
        why_ = why;
        needs_ = need::an_init;
        has_heard_stop_ = false;
    }
    /// The drive was restarted. A host that lost no more than it may read again cannot know: the command in
    /// progress may go on. The next one may begin only if the drive does not show its restart.
    void restarted() {
        if (needs_ == need::an_init) return;
        why_ = "a restart";
        needs_ = need::a_command;
    }
    /// The program has given a command.
    void ordered() {
        is_taking_over_ = of_->wanted().is_init;
        has_heard_stop_ = false;
        if (needs_ == need::a_command && !is_taking_over_ && !of_->wanted().is_stop)
            needs_ = of_->shows_restarts() ? need::an_init : need::nothing;
    }

    /// A request to the drive begins to leave.
    void begins(servobus::bytes frame) {
        is_late_unseen_ = on_->was_stalled_unseen;
        if (!of_->place().device().is_off()) return unanswered_.clear();
        if (servobus::modbus::is_write(frame[1])) {
            if (!of_->is_stop(frame) && !of_->is_setpoint(frame)) lose("a write that the drive missed");
        } else if (++unanswered_[{frame.begin(), frame.end()}] >= tries_of_a_read && !of_->has_witness()) {
            lose("reads without a response");
        }
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        follow();
        if (of_->is_stopped_by_watchdog()) {
            lose("the stop of its watchdog");
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

  private:
    enum class need : std::uint8_t { nothing, a_command, an_init };

    // After so many reads without a response a bus and a facade invalidate the cached state.
    static constexpr unsigned tries_of_a_read = 3;

    bool is_begun_by_itself(std::uint64_t motion) const {
        if (needs_ == need::a_command) return of_->is_idle();
        return needs_ == need::an_init && !goes_on_with_stop(motion);
    }
    // S3: the first frame after a stop by the watchdog is a stop, though it may not stop the drive in every
    // mode. The motion that resumes with it must have stopped when that command ends.
    bool goes_on_with_stop(std::uint64_t motion) const {
        return needs_ == need::an_init && is_let_go_by_stop_ && !of_->is_idle() && motion == stopped_motion_;
    }

    // Checks what the drive has executed: an initialisation is complete once it has stopped the drive and
    // read it.
    void follow() {
        const bool was_taking_over = is_taking_over_;
        if (of_->is_idle()) is_taking_over_ = false;
        const std::vector<execution>& all = of_->place().executed();
        auto next = all.end();
        while (next != all.begin() && std::prev(next)->transaction > seen_) --next;
        for (; next != all.end(); ++next) {
            const execution& e = *next;
            seen_ = e.transaction;
            const bool is_stop = e.is_write && of_->is_stop(frame_of(e));
            if (is_stopped_) is_let_go_by_stop_ = is_stop;
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
    need needs_ = need::nothing;
    bool is_stopped_ = false;        ///< by its watchdog, and has received nothing since
    bool is_let_go_by_stop_ = false; ///< the first request after that was a stop
    bool is_late_unseen_ = false;    ///< a stall that the program cannot know of delayed its last request
    bool is_taking_over_ = false;    ///< an initialisation is in progress
    bool has_heard_stop_ = false;    ///< the drive has received a stop since the last command
};

} // namespace trial
