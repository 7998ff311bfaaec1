// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which exchange has the line. One has it at a time, identified by its ticket; the others wait. A stop
// pre-empts an exchange whose request has not begun to leave; whether it `has_left`, the line knows.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::detail {

class arbiter {
  public:
    constexpr bool is_held() const { return holder_ != 0; }
    constexpr bool is_held_by(std::uint16_t ticket) const { return holder_ != 0 && holder_ == ticket; }
    /// A stop waits for the frame in flight.
    constexpr bool has_stop() const { return stop_ != 0; }

    constexpr std::uint16_t new_ticket() {
        if (++last_ == announced) last_ = 1;
        return last_;
    }
    /// A stop will ask soon: the next place is a stop's.
    constexpr void announce_stop(bool has_left, instant now) {
        if (stop_ == 0) wait(announced, now);
        if (!has_left && !stop_held_) holder_ = 0; // it asks again
    }

    /// Asks for the line. True if it is `ticket`'s from now on.
    constexpr bool take(std::uint16_t ticket, bool is_stop, bool has_left, instant now) {
        if (stop_ != 0 && stop_ != ticket && since(stop_seen_, now) > longest_wait) stop_ = 0;
        if (is_stop && stop_ == announced) stop_ = ticket;
        if (holder_ != 0 && (has_left || !is_stop || stop_held_)) {
            if (is_stop) wait(ticket, now);
            return false;
        }
        if (stop_ != 0 && stop_ != ticket) return false; // it came first
        holder_ = ticket;
        stop_held_ = is_stop;
        stop_ = 0;
        return true;
    }
    constexpr void release() { holder_ = 0; }
    /// The exchange is given up.
    constexpr void forget(std::uint16_t ticket) {
        if (stop_ == ticket) stop_ = 0;
    }

  private:
    // A waiting stop that is not stepped for longer than any program's loop takes is dropped.
    static constexpr duration longest_wait = milliseconds(500);
    static constexpr std::uint16_t announced = 0xFFFF; // no exchange's ticket

    constexpr void wait(std::uint16_t ticket, instant now) {
        if (stop_ == 0) stop_ = ticket;
        if (stop_ == ticket) stop_seen_ = now;
    }

    instant stop_seen_{};
    std::uint16_t holder_ = 0;
    std::uint16_t stop_ = 0;
    std::uint16_t last_ = 0;
    bool stop_held_ = false;
};

} // namespace servobus::detail
