// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How long a line waits after the last activity on the wire before it sends a request: t3.5 and the gap of
// the node, or a quarantine after an exchange that did not end in exactly one valid response.
#pragma once

#include <cstdint>

#include <servobus/core/response_limits.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::detail {

// A new line begins with a quarantine, which counts from the first look at the wire.
class line_gap {
  public:
    constexpr instant last_activity() const { return last_activity_; }
    constexpr void note_activity(instant at) { last_activity_ = at; }

    constexpr void require_quarantine() { is_quarantined_ = true; }
    // A late response begins within it, also if it is late by `more`.
    constexpr void require_quarantine_from(instant at, duration more = {}) {
        is_quarantined_ = true;
        last_activity_ = at;
        pending_quarantine_ = pending_quarantine_ + more;
    }
    // The port may still be sending a part of a request that was given up.
    constexpr void note_cut() { is_cut_ = true; }
    // Bytes that belong to no response. A few of 00h or FFh come from a driver that is switched. Any other byte
    // may belong to a second or a late response.
    constexpr void note_unexpected(bytes unexpected) {
        for (const std::uint8_t b : unexpected) {
            if ((b != 0x00 && b != 0xFF) || ++glitches_ > 4) is_quarantined_ = true;
        }
    }
    // The port was lost: what is on the wire is not received until it is back. True if that is new.
    constexpr bool note_loss() {
        if (is_unobserved_) return false;
        is_unobserved_ = true;
        return true;
    }

    // The node's own gap before a request is `wanted.gap`; its quarantine applies to what follows.
    constexpr void begin_request(const bus_gaps& wanted, priority how) {
        glitches_ = 0;
        if (how != priority::stop) {
            pending_quarantine_ = wanted.quarantine;
            is_quarantined_ = false;
        } else if (!is_quarantined_ || pending_quarantine_ < wanted.quarantine) {
            pending_quarantine_ =
                wanted.quarantine; // a stop waits for no quarantine, but what follows it does
        }
    }

    // How much of the gap is left at `now`; zero: the request may leave.
    template <class Port>
    constexpr duration left(Port& port, const modbus::rtu_timing& timing, const bus_gaps& wanted,
                            priority how, instant now) {
        duration passed = since(last_activity_, now);
        if (is_quarantined_ && (is_unobserved_ || is_cut_)) {
            is_unobserved_ = false;
            if (is_cut_ && port.sent()) is_cut_ = false;
            last_activity_ = port.now(); // after `sent`: the last bit may have left just before it
            if (is_cut_) return timing.wire_time(1);
            passed = {};
        } else if (went_back(last_activity_, now)) {
            last_activity_ = now;
            passed = {};
        }
        const duration needed = before(timing, wanted, is_quarantined_ && how != priority::stop);
        return passed < needed ? needed - passed : duration{};
    }

    // The longest time until a request may leave: another frame, a late response, may begin at the end of the
    // quarantine, which then begins anew.
    constexpr duration busy_limit(const modbus::rtu_timing& timing, const bus_gaps& wanted) const {
        return before(timing, wanted, true) * 2 + timing.wire_time(2 * modbus::max_frame);
    }

  private:
#if __SIZEOF_SIZE_T__ < 8 // one copy
    [[gnu::noinline]]
#endif
    constexpr duration
    before(const modbus::rtu_timing& timing, const bus_gaps& wanted, bool is_quarantined) const {
        const duration between_frames = longer_of(duration{timing.t3_5}, wanted.gap);
        if (!is_quarantined) return between_frames;
        return longer_of(longer_of(between_frames, timing.visible_gap()),
                         longer_of(wanted.quarantine, pending_quarantine_));
    }

    bool is_quarantined_ = true;
    bool is_unobserved_ = true; // nothing was received since the port was lost, or the line was made
    bool is_cut_ = false;
    std::uint8_t glitches_ = 0; // since the last request
    instant last_activity_{};
    duration pending_quarantine_{}; // of the node to which the last request went
};

} // namespace servobus::detail
