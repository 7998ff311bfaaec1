// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, Windows 7 or newer: the system's performance counter as the library's time, and a sleep that ends
// on time where the system has timers of high resolution (Windows 10 1803 and newer). For programs that write
// a port of their own; serial.hpp includes it.
//
//     const servobus::instant start = servobus::windows::monotonic_now();
//     servobus::windows::sleep_for(servobus::milliseconds(5));
//     const servobus::duration slept = since(start, servobus::windows::monotonic_now());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/core/time.hpp>

// <windows.h> without its macros `min` and `max`, which break <algorithm>, and without winsock.h, which keeps
// a program from including <winsock2.h> afterwards. A program that includes <windows.h> first gets all of it.
// Both macros are defined for this one line only.
#ifndef NOMINMAX
#define NOMINMAX
#define SERVOBUS_DEFINED_NOMINMAX
#endif
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#define SERVOBUS_DEFINED_LEAN
#endif
#include <windows.h>
#ifdef SERVOBUS_DEFINED_NOMINMAX
#undef NOMINMAX
#undef SERVOBUS_DEFINED_NOMINMAX
#endif
#ifdef SERVOBUS_DEFINED_LEAN
#undef WIN32_LEAN_AND_MEAN
#undef SERVOBUS_DEFINED_LEAN
#endif

namespace servobus::windows {

namespace detail {

/// The microseconds of `ticks` of a counter of `per_second`, modulo 2^64. The remainder times 10^6 does not
/// overflow below 18 THz.
constexpr std::uint64_t microseconds_of(std::uint64_t ticks, std::uint64_t per_second) {
    return ticks / per_second * 1'000'000u + ticks % per_second * 1'000'000u / per_second;
}

/// Whole milliseconds, rounded up: a wait must not end before its time.
constexpr DWORD milliseconds_of(duration d) { return d.us / 1000u + (d.us % 1000u != 0 ? 1u : 0u); }

/// A timer that a thread can wait for together with other objects. It has high resolution (about 0.5 ms)
/// where the system supports it; elsewhere `start` fails, since an ordinary timer of Windows is no better
/// than `Sleep`.
class exact_timer {
  public:
    exact_timer() : timer_{::CreateWaitableTimerExW(nullptr, nullptr, high_resolution, TIMER_ALL_ACCESS)} {}
    exact_timer(const exact_timer&) = delete;
    exact_timer& operator=(const exact_timer&) = delete;
    ~exact_timer() {
        if (timer_ != nullptr) (void)::CloseHandle(timer_);
    }

    /// Starts it. False if there is no such timer.
    bool start(duration d) const {
        if (timer_ == nullptr) return false;
        LARGE_INTEGER due{};
        due.QuadPart = -10 * std::int64_t{d.us}; // below 0: from now on, in 100 ns
        return ::SetWaitableTimer(timer_, &due, 0, nullptr, nullptr, FALSE) != 0;
    }
    HANDLE handle() const { return timer_; }

  private:
    static constexpr DWORD high_resolution = 0x2; // CREATE_WAITABLE_TIMER_HIGH_RESOLUTION, not in each SDK

    HANDLE timer_;
};

/// Waits until `object` is signalled or `d` has passed.
inline void wait_for(HANDLE object, duration d) {
    if (d == duration{}) return;
    const exact_timer timer;
    if (timer.start(d)) {
        const HANDLE both[] = {object, timer.handle()};
        (void)::WaitForMultipleObjects(2, both, FALSE, milliseconds_of(d) + 100);
    } else {
        (void)::WaitForSingleObject(object, milliseconds_of(d));
    }
}

} // namespace detail

/// The time of the performance counter in microseconds; wraps every 71.6 minutes, as `instant` does.
inline instant monotonic_now() {
    LARGE_INTEGER frequency{};
    LARGE_INTEGER counter{};
    (void)::QueryPerformanceFrequency(&frequency); // cannot fail since Windows XP, and makes no system call
    (void)::QueryPerformanceCounter(&counter);
    return {static_cast<std::uint32_t>(detail::microseconds_of(
        static_cast<std::uint64_t>(counter.QuadPart), static_cast<std::uint64_t>(frequency.QuadPart)))};
}

/// Sleeps for `d`. Without a timer of high resolution it ends with a tick of the system, up to 16 ms late.
inline void sleep_for(duration d) {
    if (d == duration{}) return;
    const detail::exact_timer timer;
    if (timer.start(d)) {
        (void)::WaitForSingleObject(timer.handle(), INFINITE);
    } else {
        ::Sleep(detail::milliseconds_of(d));
    }
}

} // namespace servobus::windows
