// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Faults of a line whose program goes on meanwhile, one at a time: the wire is cut, another node sends
// without pause, the port is lost for a time, the clock stops, jumps or wraps.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "world.hpp"

namespace trial {

class mishaps {
  public:
    explicit mishaps(world& in) : in_{in} {}

    /// Called when the port returns and the program knows that it was lost.
    std::function<void()> on_port_back;

    /// The run begins. A late response begins within the quarantine after its request, since any fault may
    /// end an exchange early.
    void begin() {
        in_.state().may_end_early = in_.events != 0;
        if (in_.events != 0) in_.begin_to_stall();
    }

    /// Perhaps begins a fault, now or soon.
    void draw() {
        scene& on = in_.state();
        if (is_near() || on.random.below(1000) >= in_.events) return;
        switch (on.random.below(8)) {
        case 0: return cut();
        case 1:
        case 2: return send();
        case 3:
        case 4: return lose_port();
        default: return upset_clock();
        }
    }

    /// The port is lost, now or soon, and returns.
    void lose_port() {
        scene& on = in_.state();
        const std::uint64_t when = on.now() + on.random.below(50'000);
        const std::uint64_t back = when + any_time();
        over_at(back);
        in_.port().plan(when, [this, back] {
            in_.state().strikes(strike::lost_port);
            in_.port().vanish();
            in_.port().plan(back, [this] { come_back_if_missed(); });
        });
    }

    /// A fault is active or planned, or its effects are still on the line.
    bool is_near() const { return in_.state().now() < over_at_ || in_.port().is_gone(); }

    /// Called once in each iteration of the program's loop.
    void look() {
        if (!in_.state().does_clock_lie || is_near()) return;
        in_.state().does_clock_lie = false;
        in_.state().chance = in_.hostility;
    }

    /// Ends all faults.
    void heal() {
        in_.port().stalling.end();
        in_.port().forget_plans();
        if (in_.port().is_gone()) come_back();
        if (in_.state().is_clock_still) start_clock();
        in_.wire().cut_for({});
        in_.others().sender.stop();
        in_.state().sounding_until = in_.state().now();
        // A clock that jumped or stopped has shown gaps that did not exist. This rest replaces them.
        if (in_.state().does_clock_lie) in_.rest(longest());
        in_.state().does_clock_lie = false;
        over_at_ = 0;
    }

  private:
    void over_at(std::uint64_t at) { over_at_ = std::max(over_at_, at + longest()); }
    // After this time everything that belongs to an exchange has ended, also a late response.
    std::uint64_t longest() const {
        std::uint64_t most = 0;
        for (const auto& s : in_.participants())
            most = std::max<std::uint64_t>(most, s->limits().response.us + s->gaps().quarantine.us);
        return 2 * most + in_.state().wire_time(700);
    }
    // Mostly below 400 ms.
    std::uint32_t any_time() {
        scene& on = in_.state();
        return 1000u * (on.one_in(3) ? on.between(400, 3000) : on.between(1, 400));
    }

    void cut() {
        in_.state().strikes(strike::stuck_line);
        const std::uint32_t time = any_time();
        in_.wire().cut_for(servobus::duration{time});
        over_at(in_.state().now() + time);
    }
    void send() { over_at(in_.let_talk(in_.state().between(100'000, 3'000'000))); }

    // The port returns only after it has reported its loss. A program that calls no function of the port
    // meanwhile could not know of the loss.
    void come_back_if_missed() {
        constexpr std::uint64_t a_while = 1000;
        const std::uint64_t now = in_.state().now();
        over_at(now);
        if (in_.port().has_said_so()) return come_back();
        in_.port().plan(now + a_while, [this] { come_back_if_missed(); });
    }
    void come_back() {
        in_.state().log->remark(in_.state().now(), "the port returns");
        const bool was_missed = in_.port().has_said_so(); // else the program cannot know of it
        in_.port().come_back();
        if (on_port_back && was_missed) on_port_back();
    }

    // A backward jump shortens no gap and no quarantine. With any other clock fault the program cannot keep
    // them, so no response is late meanwhile.
    void upset_clock() {
        scene& on = in_.state();
        const std::uint32_t which = on.random.below(4);
        const bool is_back = which == 1;
        if (!is_back) {
            on.chance = 0;
            on.does_clock_lie = true;
        }
        const std::uint64_t when = on.now() + longest();
        over_at(when);
        switch (which) {
        case 0: return stop_clock(when);
        case 1: return jump(when, strike::clock_back, -std::min(way(), std::int64_t{2'000'000'000}));
        case 2: return jump(when, strike::clock_forward, way());
        default: in_.port().plan(when, [this] { go_to_wrap(); });
        }
    }
    std::int64_t way() {
        scene& on = in_.state();
        return on.one_in(3) ? std::int64_t{on.between(1, 4000)} * 1'000'000
                            : std::int64_t{on.between(1000, 500'000)};
    }
    void jump(std::uint64_t when, strike what, std::int64_t by) {
        in_.port().plan(when, [this, what, by] {
            in_.state().strikes(what);
            if (by < 0) in_.state().jumped_back_at = in_.state().now();
            in_.port().jump(by);
        });
    }
    // Sets the clock to at most 500 ms before its wrap, so that it wraps while the program runs.
    void go_to_wrap() {
        in_.state().strikes(strike::clock_wrap);
        const std::uint32_t left = 0u - in_.port().shown_us();
        in_.port().jump(std::int64_t{left} - in_.state().between(1, 500'000));
    }
    void stop_clock(std::uint64_t when) {
        const std::uint32_t time = any_time();
        over_at(when + time);
        in_.port().plan(when, [this, when, time] {
            in_.state().strikes(strike::clock_stopped);
            in_.state().is_clock_still = true;
            in_.port().stop_clock(true);
            in_.port().plan(when + time, [this] { start_clock(); });
        });
    }
    void start_clock() {
        in_.state().is_clock_still = false;
        in_.port().stop_clock(false);
    }

    world& in_;
    std::uint64_t over_at_ = 0;
};

} // namespace trial
