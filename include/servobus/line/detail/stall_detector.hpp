// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A loop that waits by a clock must end even if the clock does not go on.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus {

namespace detail {
// Distinguishes a clock that has stopped, or jumps back again and again, from one with a coarse tick.
class stall_detector {
  public:
    constexpr stall_detector(instant start, std::uint32_t most) : last_{start}, most_{most} {}

    constexpr bool has_failed(instant now) {
        if (now == last_) return ++polls_ > most_;
        if (went_back(last_, now) && ++jumps_ > 8) return true;
        last_ = now;
        polls_ = 0;
        return false;
    }

  private:
    instant last_;
    std::uint32_t most_;
    std::uint32_t polls_ = 0;
    std::uint32_t jumps_ = 0;
};

// Looks at a clock that shows the same before it is taken for stopped: a loop that sleeps looks less often.
inline constexpr std::uint32_t looks_polling = 4'000'000;
inline constexpr std::uint32_t looks_sleeping = 10'000;
inline constexpr duration longest_sleep = milliseconds(5);
} // namespace detail

} // namespace servobus
