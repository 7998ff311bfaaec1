// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive of which nothing can be known any more: its motor begins no motion until the program has had it
// initialised again (G20, G21, S3, S5). Told by what the drive is commanded to do and what it was sent.
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

    /// Nothing of the drive is known from now on.
    void lose(const char* why) {
        why_ = why;
        needs_ = need::an_init;
        has_heard_stop_ = false;
    }
    /// The drive was restarted. A host that lost no more than it may ask for again cannot know: the order
    /// under way may go on, and the next may begin.
    void restarted() {
        if (needs_ == need::an_init) return;
        why_ = "a restart";
        needs_ = need::an_order;
    }
    /// The program has given an order.
    void ordered() {
        is_taking_over_ = of_->wanted().is_init;
        has_heard_stop_ = false;
        if (needs_ == need::an_order && !is_taking_over_ && !of_->wanted().is_stop) needs_ = need::nothing;
    }

    /// A request to the drive begins to leave.
    void begins(servobus::bytes frame) {
        is_late_unseen_ = on_->was_stalled_unseen;
        if (!of_->place().device().is_off()) return unanswered_.clear();
        if (servobus::modbus::is_write(frame[1])) {
            if (!of_->is_stop(frame)) lose("a write that nobody heard");
        } else if (++unanswered_[{frame.begin(), frame.end()}] >= tries_of_a_read && !of_->has_watchdog()) {
            lose("reads that nobody answered");
        }
    }

    /// The program's loop has been round once.
    void look() {
        follow();
        if (of_->is_stopped_by_watchdog()) {
            lose("the stop of its watchdog");
            is_stopped_ = true;
            stopped_motion_ = of_->resumed_motion(); // also what was ordered in the same stall
        }
        const std::uint64_t motion = of_->motion();
        if (motion == motion_) return;
        // Who has no time sees no silence, nor who stalls between the look at the clock and the frame.
        if (motion != 0 && (on_->is_clock_still || is_late_unseen_)) needs_ = need::nothing;
        if (motion != 0 && is_begun_by_itself(motion))
            throw broken{"G21: after " + std::string{why_} + " unit " + std::to_string(of_->place().unit()) +
                         " moves, and has not been initialised"};
        if (motion == 0) stopped_motion_ = is_stopped_ ? of_->resumed_motion() : motion_;
        if (!goes_on_with_stop(motion)) motion_ = motion;
    }

  private:
    enum class need : std::uint8_t { nothing, an_order, an_init };

    // What a bus and a facade take for silence.
    static constexpr unsigned tries_of_a_read = 3;

    bool is_begun_by_itself(std::uint64_t motion) const {
        if (needs_ == need::an_order) return of_->is_idle();
        return needs_ == need::an_init && !goes_on_with_stop(motion);
    }
    // S3: the first frame after a watchdog's stop is one that stops, if not yet in every mode. What goes on
    // with it must stand again when that order is over.
    bool goes_on_with_stop(std::uint64_t motion) const {
        return needs_ == need::an_init && is_let_go_by_stop_ && !of_->is_idle() && motion == stopped_motion_;
    }

    // What it has executed: an initialisation has stopped it and read it since.
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
        byte_list f{of_->place().unit(),    0x10,
                    high(e.address),        low(e.address),
                    high(e.words.size()),   low(e.words.size()),
                    low(2 * e.words.size())};
        for (const std::uint16_t w : e.words) f.insert(f.end(), {high(w), low(w)});
        return f;
    }

    const scene* on_;
    facade* of_;
    std::map<byte_list, unsigned> unanswered_; ///< reads, in a row
    const char* why_ = "";
    std::uint64_t motion_ = 0;
    std::uint64_t stopped_motion_ = 0; ///< before it stood
    std::uint64_t seen_ = 0;           ///< the last execution
    need needs_ = need::nothing;
    bool is_stopped_ = false;        ///< by its watchdog, and has heard nothing since
    bool is_let_go_by_stop_ = false; ///< what it heard first then was a stop
    bool is_late_unseen_ = false;    ///< its last request, by a stall that the program cannot know of
    bool is_taking_over_ = false;    ///< an initialisation is under way
    bool has_heard_stop_ = false;    ///< since then
};

} // namespace trial
