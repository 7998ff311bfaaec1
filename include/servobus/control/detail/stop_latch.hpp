// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stop that was not confirmed yet: it is repeated until it is, or until a command that succeeds replaces it.
//
//     none --a stop ends without confirmation--> open --a stop, a take-over or a motion is done--> none
#pragma once

#include <cstdint>

#include <servobus/control/states.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

class stop_latch {
  public:
    constexpr bool is_open() const { return priority_ != stop_priority::no_stop; }
    constexpr stop_priority priority() const { return priority_; }
    /// Frames of it that still go before all other traffic. Repetitions do not: other drives must get their
    /// requests.
    constexpr std::uint8_t urgent_left() const { return urgent_left_; }
    constexpr bool is_due(duration every, instant now) const {
        return is_open() && every != duration{} && since(tried_, now) >= every;
    }

    constexpr void close() { priority_ = stop_priority::no_stop; }
    /// `was_sent`: any frame of it has left.
    constexpr void open(stop_priority priority, std::uint8_t urgent_left, bool was_sent, instant now) {
        priority_ = priority;
        urgent_left_ = was_sent ? std::uint8_t{0} : urgent_left;
        tried_ = now;
    }

  private:
    instant tried_{};
    stop_priority priority_ = stop_priority::no_stop;
    std::uint8_t urgent_left_ = 0;
};

} // namespace servobus::detail
