// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The stops of a bus: each is the next frame after the one in flight and in time (G25), and is repeated where
// nobody has confirmed it (G26).
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
    /// The application orders something else: what nobody has confirmed stays open meanwhile.
    void ordered_another(facade* by) {
        stop_of(by).is_under_way = false;
        forget_pending(by);
    }
    bool is_quiet() const { return pending_.empty(); }

    /// A request begins to leave.
    void begins(servobus::bytes frame, facade* whose, bool is_urgent) {
        for (stop& s : stops_) s.urgent_frames += is_urgent ? 1u : 0u;
        const bool is_stop = whose != nullptr && whose->is_stop(frame);
        // After a stall that was longer than a stop waits for a busy line, one read may come before its next
        // attempt.
        const bool is_due = !pending_.empty() && now() > pending_.front().ordered_at &&
                            in_.state().stalled_us == pending_.front().stalled_us;
        if (!is_urgent && is_due)
            throw broken{"G25: a frame that is not urgent goes before the stop of unit " +
                         std::to_string(pending_.front().by->place().unit())};
        if (!is_stop) return;
        stop_of(whose).sent_at = now();
        stop_of(whose).urgent_frames = 0;
        for (const pending& p : pending_) {
            if (p.by == whose) check_latency(p, frame.size());
        }
        forget_pending(whose);
    }

    /// The program's loop has been round once.
    void look() {
        for (const auto& f : in_.facades()) {
            stop& s = stop_of(f.get());
            // Nothing can have confirmed a stop of which the drive has heard nothing.
            s.is_unheard = s.is_unheard && f->place().device().is_off();
            if (s.is_under_way && f->is_idle()) {
                s.is_under_way = false;
                s.is_open = s.is_unheard;
                s.open_since = now();
                // Where the line or the port let nothing through, the program was told so.
                if (in_.events != 0) forget_pending(f.get());
            }
            s.is_open = s.is_open && s.is_unheard;
            if (!f->is_idle()) s.open_since = now();
            if (s.is_open && f->last() && f->is_idle())
                throw broken{"G26: a stop is said to be confirmed, and the drive was not there"};
            const std::uint64_t last = std::max(s.open_since, s.sent_at);
            if (s.is_open && in_.is_faultless() && now() - last > longest_pause(s))
                throw broken{"G26: the stop of unit " + std::to_string(f->place().unit()) +
                             " is not confirmed, and not repeated for " + std::to_string(now() - last) +
                             " us"};
        }
    }

  private:
    struct pending {
        facade* by;
        std::uint64_t ordered_at;
        std::uint64_t stalled_us; ///< by the program until then
    };
    struct stop {
        bool is_under_way = false;
        bool is_open = false;
        bool is_unheard = false;
        std::uint64_t open_since = 0;
        std::uint64_t sent_at = 0;
        std::uint32_t urgent_frames = 0; ///< of others since, which the application has ordered
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
        const std::uint64_t took = now() + in_.state().wire_time(size) - p.ordered_at;
        const std::uint32_t most = bus_.stop_latency_us(static_cast<std::uint32_t>(in_.facades().size()));
        if (took > most + loop_us)
            throw broken{"G25: a stop was on the wire after " + std::to_string(took) + " us only, at most " +
                         std::to_string(most) + " is promised"};
    }
    std::uint64_t longest_pause(const stop& s) const {
        return bus_.longest_stop_pause_us() + loop_us +
               std::uint64_t{s.urgent_frames} * bus_.longest_stop_us();
    }

    // A look at the clock costs a microsecond, and a turn of the loop a few looks.
    static constexpr std::uint64_t loop_us = 100;

    facade_world& in_;
    fleet& bus_;
    std::vector<stop> stops_;
    std::vector<pending> pending_;
};

} // namespace trial
