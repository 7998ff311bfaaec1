// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, POSIX: the system's monotonic clock as the library's time, and a sleep that ends on time. For
// programs that write a port of their own; serial.hpp, tcp.hpp and
// pseudo_terminal.hpp include it.
//
//     const servobus::instant start = servobus::posix::monotonic_now();
//     servobus::posix::sleep_for(servobus::milliseconds(5));
//     const servobus::duration slept = since(start, servobus::posix::monotonic_now());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <time.h>

#include <servobus/core/time.hpp>
#include <servobus/posix/detail/system.hpp>

namespace servobus::posix {

/// The time of CLOCK_MONOTONIC in microseconds; wraps every 71.6 minutes, as `instant` does.
inline instant monotonic_now() {
    timespec t{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &t);
    const auto us =
        static_cast<std::uint64_t>(t.tv_sec) * 1'000'000u + static_cast<std::uint64_t>(t.tv_nsec) / 1000u;
    return {static_cast<std::uint32_t>(us)};
}

/// Sleeps for `d`, or until a signal is handled. On Linux the thread's timer slack does not lengthen the
/// sleep.
inline void sleep_for(duration d) {
    const detail::exact_wake_up precisely;
    const timespec t = detail::to_timespec(d);
    (void)::nanosleep(&t, nullptr);
}

} // namespace servobus::posix
