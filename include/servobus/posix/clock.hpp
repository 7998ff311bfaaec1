// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted: the system's monotonic clock as the library's time, and a sleep that ends when it was asked to.
#pragma once

#include <cstdint>

#include <errno.h>
#include <sys/prctl.h>
#include <time.h>

#include <servobus/core/time.hpp>

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

/// While it lives, a sleep of this thread ends when it is due. Linux wakes an ordinary thread up to its timer
/// slack later, 50 us unless it was told otherwise, which is a fifth of a short frame at 115200 Bd. The
/// thread's own slack is put back at the end: everything else that the program sleeps for is as the program
/// wants it.
class exact_wake_up {
  public:
    exact_wake_up() : slack_ns_{::prctl(PR_GET_TIMERSLACK)} {
        if (slack_ns_ > 1) (void)::prctl(PR_SET_TIMERSLACK, 1ul);
    }
    exact_wake_up(const exact_wake_up&) = delete;
    exact_wake_up& operator=(const exact_wake_up&) = delete;
    ~exact_wake_up() {
        if (slack_ns_ > 1) (void)::prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_ns_));
    }

  private:
    int slack_ns_; // below 0: it cannot be read, and is left alone
};
} // namespace detail

/// Sleeps for `d`, or until a signal is handled. The thread's timer slack does not lengthen it.
inline void sleep_for(duration d) {
    const detail::exact_wake_up precisely;
    const timespec t = detail::to_timespec(d);
    (void)::nanosleep(&t, nullptr);
}

} // namespace servobus::posix
