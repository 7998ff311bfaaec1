// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A loop that waits by a clock must end even if the clock does not go on.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>
#include <servobus/line/port.hpp>

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

/// The looks of a line over this kind of port. A test whose port stops its clock often specialises both numbers.
template <class Port>
inline constexpr std::uint32_t most_looks = waiting_port<Port> ? looks_sleeping : looks_polling;
/// About as many, as a power of 2, for a blocking line: no constant to load.
template <class Port> inline constexpr unsigned most_looks_log2 = waiting_port<Port> ? 13 : 22;
} // namespace detail

} // namespace servobus
