// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The client's port: the end of the virtual line, with a clock that may be wrong. Events that are planned
// for a given time happen in its calls.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <servobus/sim/line.hpp>

#include "echo_path.hpp"
#include "judge.hpp"
#include "scene.hpp"
#include "stalls.hpp"

namespace trial {

class shaky_port {
  public:
    shaky_port(scene& on, judge& who, std::uint32_t resolution_us)
        : echo{on}, on_{&on}, judge_{&who}, resolution_us_{resolution_us} {}

    servobus::transfer send(servobus::bytes out) {
        (void)pause();
        on_->was_stalled_unseen = has_stalled_;
        look();
        const std::size_t most =
            takes_at_most != 0 && out.size() > takes_at_most ? takes_at_most : out.size();
        // A frame that the port takes in parts continues when the line offers its rest.
        const bool begins = !is_rest(out);
        if (begins && before_request && !is_gone()) before_request(out);
        if (begins && !is_gone()) judge_->begins(on_->now(), out);
        if (begins && !is_gone()) echo.begins(out.size());
        const servobus::transfer took = wire().send(out.first(most));
        note(took);
        if (took && *took != 0 && on_taken) on_taken(out.first(*took));
        if (took && *took != 0) {
            if (begins) taken_of_.assign(out.begin(), out.end());
            if (begins) left_to_take_ = out.size();
            is_sending_ = true;
            has_arrived_ = false;
            left_to_take_ -= *took;
        }
        (void)pause();
        return took;
    }
    bool sent() {
        (void)pause();
        look();
        const bool is = wire().sent();
        if (is && is_sending_ && left_to_take_ == 0) {
            is_sending_ = false;
            on_->left_us = on_->now();
            judge_->left();
        }
        return is;
    }
    servobus::transfer receive(servobus::byte_buffer in) {
        if (stalls_before_receive) (void)pause();
        look();
        const servobus::transfer came = echo.pass_on(in, echo.is_holding() ? 0 : wire().receive(in));
        note(came);
        has_arrived_ = has_arrived_ || (came && *came != 0);
        if (came) judge_->heard(servobus::bytes{in}.first(*came));
        if (!came) is_sending_ = false;
        return came;
    }
    servobus::instant now() {
        (void)pause();
        look();
        (void)wire().now();
        on_->clock_read_us = on_->now();
        return {shown_us()};
    }
    void wait(servobus::duration longest) {
        (void)pause();
        look();
        const std::uint64_t end = on_->now() + longest.us;
        const std::uint64_t until = next_plan() < end ? next_plan() : end;
        // Bytes that the adapter holds back do not end the wait.
        if (echo.is_holding()) {
            const std::uint64_t given = on_->held_until < until ? on_->held_until : until;
            if (given > on_->now())
                wire().pass(servobus::duration{static_cast<std::uint32_t>(given - on_->now())});
        } else if (until > on_->now()) {
            wire().wait(servobus::duration{static_cast<std::uint32_t>(until - on_->now())});
        }
        look();
    }

    /// A party of the program begins a step: it reads the clock, and then may send.
    void begin_turn() { has_stalled_ = false; }

    /// Plans an event at a time. It happens at the first call of `look` from then on.
    void plan(std::uint64_t at_us, std::function<void()> what) { plans_.push_back({at_us, std::move(what)}); }
    /// Removes all planned events.
    void forget_plans() { plans_.clear(); }
    void look() {
        for (std::size_t i = 0; i < plans_.size();) {
            if (plans_[i].at_us > on_->now()) {
                ++i;
                continue;
            }
            const std::function<void()> what = std::move(plans_[i].what);
            plans_.erase(plans_.begin() + static_cast<std::ptrdiff_t>(i));
            what();
        }
    }

    std::uint64_t next_plan() const {
        std::uint64_t next = ~std::uint64_t{0};
        for (const planned& p : plans_) next = p.at_us < next ? p.at_us : next;
        return next;
    }
    bool has_plans() const { return !plans_.empty(); }

    void jump(std::int64_t by_us) { offset_us_ += static_cast<std::uint32_t>(by_us); }
    void stop_clock(bool is_stopped) {
        stopped_at_us_ = shown();
        stopped_ = is_stopped;
    }
    void vanish() {
        is_gone_ = true;
        has_said_so_ = false;
        is_sending_ = false;
        echo.is_lost();
        judge_->forget_arrivals();
        wire().unplug();
    }
    void come_back() {
        is_gone_ = false;
        wire().plug();
    }
    bool is_gone() const { return is_gone_; }
    /// A part of a request has been taken, and `sent` has not yet reported that its last bit has left.
    bool is_leaving() const { return is_sending_; }
    /// A call has reported `port_lost`.
    bool has_said_so() const { return has_said_so_; }
    /// The time on the clock, without the cost of reading it.
    std::uint32_t shown_us() const { return stopped_ ? stopped_at_us_ : shown(); }
    /// The exchange in progress was given up: the rest of its request will never be taken.
    void forget_request() { is_sending_ = false; }

    std::size_t takes_at_most = 0; ///< bytes in one `send`; 0: all
    stalls stalling;
    bool stalls_before_receive = true;
    std::function<void(servobus::bytes)> before_request;
    std::function<void(servobus::bytes)> on_taken; ///< receives the bytes that one call of `send` took
    echo_path echo;

  private:
    struct planned {
        std::uint64_t at_us;
        std::function<void()> what;
    };

    servobus::sim::virtual_line& wire() { return *on_->wire; }
    // These bytes are the rest of the frame that is leaving, not the beginning of another one.
    bool is_rest(servobus::bytes out) const {
        return left_to_take_ != 0 && out.size() == left_to_take_ &&
               std::equal(out.begin(), out.end(),
                          taken_of_.end() - static_cast<std::ptrdiff_t>(left_to_take_));
    }
    // Perhaps the program stalls here. Planned events still happen when they are due.
    bool pause() {
        const place at = is_sending_        ? place::leaving
                         : !on_->is_awaited ? place::between
                         : has_arrived_     ? place::receiving
                                            : place::awaiting;
        const std::uint32_t us = stalling.draw_us(at);
        if (us == 0) return false;
        has_stalled_ = true;
        on_->strikes(strike::stall);
        on_->count->note(on_->kinds[on_->asked_node], at);
        on_->stalled_us += us;
        const std::uint64_t end = on_->now() + us;
        while (on_->now() < end) {
            look();
            const std::uint64_t next = next_plan() < end ? next_plan() : end;
            if (next > on_->now())
                wire().pass(servobus::duration{static_cast<std::uint32_t>(next - on_->now())});
        }
        on_->hide_pause();
        return true;
    }
    void note(const servobus::transfer& t) {
        if (!t && t.error() == servobus::errc::port_lost) has_said_so_ = true;
    }
    std::uint32_t shown() const {
        const std::uint32_t us = on_->wire->clock().us + offset_us_;
        return us - us % resolution_us_;
    }

    scene* on_;
    judge* judge_;
    std::vector<planned> plans_;
    std::uint32_t resolution_us_;
    std::uint32_t offset_us_ = 0;
    std::uint32_t stopped_at_us_ = 0;
    std::size_t left_to_take_ = 0;
    byte_list taken_of_; ///< the frame that is leaving
    bool stopped_ = false;
    bool is_gone_ = false;
    bool has_said_so_ = false;
    bool is_sending_ = false;
    bool has_arrived_ = false; // a byte of the response
    bool has_stalled_ = false; // in this step
};

static_assert(servobus::waiting_port<shaky_port>);

} // namespace trial
