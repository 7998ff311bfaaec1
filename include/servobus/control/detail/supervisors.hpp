// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What makes a facade stop its drive although the application does not ask for it: an application that has stopped
// commanding a motion that does not end by itself, and a stop that was not confirmed yet.
//
//     not watched --an endless motion begins--> watched --a stop is done, or the command timeout--> not watched
//     no stop --a stop ends without confirmation--> open --a stop, a take-over or a motion is done--> no stop
#pragma once

#include <cstdint>

#include <servobus/control/states.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

class supervisors {
  public:
    /// `limit`: the command timeout, 0 for none. Stops are repeated as often.
    constexpr explicit supervisors(duration limit)
        : limit_{or_never(limit)}, repeat_every_{or_never(limit)} {}

    // --- The command timeout

    /// Another limit; the period of the stops follows unless it was set by itself.
    constexpr void set_limit(duration limit, instant now) {
        if (repeat_every_ == limit_) repeat_stops(limit);
        limit_ = or_never(limit);
        commanded_at_ = now;
    }
    constexpr void watch(instant now) {
        is_watched_ = true;
        commanded_at_ = now;
    }
    constexpr void end_watch() { is_watched_ = false; }
    /// The application commands or waits.
    constexpr void note_command(instant now) { commanded_at_ = now; }
    constexpr bool has_run_out(instant now) const {
        return is_watched_ && since(commanded_at_, now) > limit_;
    }

    // --- The stop that was not confirmed

    /// 0: never.
    constexpr void repeat_stops(duration every) { repeat_every_ = or_never(every); }
    constexpr bool is_stop_open() const { return open_stop_ != stop_priority::no_stop; }
    constexpr stop_priority open_stop() const { return open_stop_; }
    /// Frames of it that still go before all other traffic. Repetitions do not: other drives must get their
    /// requests.
    constexpr std::uint8_t urgent_left() const { return urgent_left_; }
    constexpr bool is_stop_due(instant now) const {
        return is_stop_open() && since(tried_, now) >= repeat_every_;
    }
    constexpr void close_stop() { open_stop_ = stop_priority::no_stop; }
    /// `was_sent`: any frame of it has left.
    constexpr void open_stop(stop_priority priority, std::uint8_t urgent_left, bool was_sent, instant now) {
        open_stop_ = priority;
        urgent_left_ = was_sent ? std::uint8_t{0} : urgent_left;
        tried_ = now;
    }

  private:
    // Longer than any time that a clock of 32 bits can tell.
    static constexpr duration or_never(duration d) { return d == duration{} ? duration{0xFFFF'FFFF} : d; }

    stop_priority open_stop_ = stop_priority::no_stop;
    std::uint8_t urgent_left_ = 0;
    bool is_watched_ = false; // a motion without an end was commanded, and not stopped since
    duration limit_;
    duration repeat_every_;
    instant commanded_at_{};
    instant tried_{};
};

} // namespace servobus::detail
