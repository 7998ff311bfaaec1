// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The stops of a bus: each is the next frame after the one in progress and in time (G25), and is repeated
// until it is confirmed (G26). Of a facade it reads what it reports of a stop: that it has ended, and how.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fleet.hpp"

namespace trial {

class stop_watch {
  public:
    stop_watch(facade_world& in, fleet& of) : in_{in}, bus_{of}, stops_(in.facades().size()) {}

    void ordered(facade* by) {
        stop_of(by).is_under_way = true;
        stop_of(by).is_open = false;
        stop_of(by).is_unheard = true;
        const bool waits =
            std::any_of(pending_.begin(), pending_.end(), [by](const pending& p) { return p.by == by; });
        if (!waits) pending_.push_back({by, now(), in_.state().stalled_us});
    }
    /// The application commands something else. An unconfirmed stop stays open meanwhile.
    void commanded_another(facade* by) {
        stop_of(by).is_under_way = false;
        forget_pending(by);
    }
    bool is_quiet() const { return pending_.empty(); }

    /// A request begins to leave.
    void begins(servobus::bytes frame, facade* whose, bool as_stop) {
        for (stop& s : stops_) s.urgent_frames += as_stop ? 1u : 0u;
        const bool is_stop = whose != nullptr && whose->is_stop(frame);
        if (whose != nullptr) stop_of(whose).open_since = now(); // a command under way comes first
        // A program that stalls for half a second loses the place of its stop: one frame may come before it. Stalls
        // add up, so a little less excuses it.
        const bool is_due = !pending_.empty() && now() > pending_.front().commanded_at &&
                            in_.state().stalled_us - pending_.front().stalled_us < shortest_loss_us;
        if (!as_stop && is_due)
            throw broken{"G25: another frame was sent before the stop of node " +
                         std::to_string(pending_.front().by->place().address())};
        if (!is_stop) return;
        stop_of(whose).sent_at = now();
        stop_of(whose).urgent_frames = 0;
        for (const pending& p : pending_) {
            if (p.by == whose) check_latency(p, frame.size());
        }
        forget_pending(whose);
    }

    /// Called once in each iteration of the program's loop.
    void look() {
        for (const auto& f : in_.facades()) {
            stop& s = stop_of(f.get());
            // A drive that was off all the time cannot have confirmed the stop.
            s.is_unheard = s.is_unheard && f->place().device().is_off();
            if (s.is_under_way && f->is_idle()) {
                s.is_under_way = false;
                s.is_open = s.is_unheard;
                s.open_since = now();
                // If the line or the port let nothing through, the program has received an error.
                if (in_.events != 0) forget_pending(f.get());
            }
            s.is_open = s.is_open && s.is_unheard;
            if (s.is_open && f->last() && f->is_idle())
                throw broken{"G26: a stop is reported confirmed, but the drive was off"};
            const std::uint64_t last = std::max(s.open_since, s.sent_at);
            if (s.is_open && in_.is_faultless() && now() - last > longest_pause(s))
                throw broken{"G26: the stop of node " + std::to_string(f->place().address()) +
                             " is not confirmed, but has not been repeated for " +
                             std::to_string(now() - last) + " us"};
        }
    }

  private:
    struct pending {
        facade* by;
        std::uint64_t commanded_at;
        std::uint64_t stalled_us; ///< total time of stalls until then
    };
    struct stop {
        bool is_under_way = false;
        bool is_open = false;
        bool is_unheard = false;
        std::uint64_t open_since = 0;
        std::uint64_t sent_at = 0;
        std::uint32_t urgent_frames = 0; ///< stops of other drives since, commanded by the application
    };

    std::uint64_t now() const { return in_.state().now(); }
    stop& stop_of(const facade* f) {
        std::size_t i = 0;
        while (in_.facades()[i].get() != f) ++i;
        return stops_[i];
    }

    void forget_pending(const facade* by) {
        std::erase_if(pending_, [by](const pending& p) { return p.by == by; });
    }

    // Others may stop, or stop again, at the same time.
    void check_latency(const pending& p, std::size_t size) const {
        if (!in_.is_faultless()) return;
        const std::uint64_t took = now() + in_.state().wire_time(size) - p.commanded_at;
        const std::uint32_t most = bus_.stop_latency_us(static_cast<std::uint32_t>(in_.facades().size()));
        if (took > most + loop_us)
            throw broken{"G25: a stop was on the wire after " + std::to_string(took) + " us, at most " +
                         std::to_string(most) + " is promised"};
    }
    std::uint64_t longest_pause(const stop& s) const {
        return bus_.longest_stop_pause_us() + loop_us +
               std::uint64_t{s.urgent_frames} * bus_.longest_stop_us();
    }

    // Each reading of the clock takes a microsecond, and each loop iteration reads it a few times.
    static constexpr std::uint64_t loop_us = 100;
    static constexpr std::uint64_t shortest_loss_us = 400'000;

    facade_world& in_;
    fleet& bus_;
    std::vector<stop> stops_;
    std::vector<pending> pending_;
};

} // namespace trial
