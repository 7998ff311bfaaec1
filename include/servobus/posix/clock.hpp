// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, Linux: the system's monotonic clock as the library's time, and a sleep that ends on time. For
// programs that write a port of their own; serial.hpp and pseudo_terminal.hpp include it.
//
//     const servobus::instant start = servobus::posix::monotonic_now();
//     servobus::posix::sleep_for(servobus::milliseconds(5));
//     const servobus::duration slept = since(start, servobus::posix::monotonic_now());
#pragma once

#include <cstdint>

#include <errno.h>
#include <sys/prctl.h>
#include <time.h>

#include <servobus/core/time.hpp>

namespace servobus::posix {

/// The time of CLOCK_MONOTONIC in microseconds; wraps every 71.6 minutes, as `instant` does.
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

/// Sets the thread's timer slack to the minimum during its lifetime, and restores it afterwards, so that
/// other sleeps of the program keep the slack that the program chose. Linux wakes an ordinary thread up to
/// its timer slack late: 50 us by default, a fifth of the wire time of a short frame at 115200 Bd.
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
    int slack_ns_; // below 0 if it cannot be read; then it is not changed
};
} // namespace detail

/// Sleeps for `d`, or until a signal is handled. The thread's timer slack does not lengthen the sleep.
inline void sleep_for(duration d) {
    const detail::exact_wake_up precisely;
    const timespec t = detail::to_timespec(d);
    (void)::nanosleep(&t, nullptr);
}

} // namespace servobus::posix
