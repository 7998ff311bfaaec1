// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted: the system's monotonic clock as the library's time, and a sleep.
#pragma once

#include <cstdint>

#include <errno.h>
#include <time.h>

#include <servobus/time.hpp>

namespace servobus::posix {

/// Microseconds of CLOCK_MONOTONIC; wraps every 71.6 minutes as `instant` does.
inline instant monotonic_now() {
    timespec t{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &t);
    const auto us =
        static_cast<std::uint64_t>(t.tv_sec) * 1'000'000u + static_cast<std::uint64_t>(t.tv_nsec) / 1000u;
    return {static_cast<std::uint32_t>(us)};
}

namespace detail {
inline timespec to_timespec(duration d) {
    timespec t{};
    t.tv_sec = static_cast<time_t>(d.us / 1'000'000u);
    t.tv_nsec = static_cast<long>(d.us % 1'000'000u) * 1000;
    return t;
}
} // namespace detail

/// Sleeps for `d`, or until a signal is handled.
inline void sleep_for(duration d) {
    const timespec t = detail::to_timespec(d);
    (void)::nanosleep(&t, nullptr);
}

} // namespace servobus::posix
