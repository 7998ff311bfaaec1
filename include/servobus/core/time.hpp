// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Durations and instants in 32 bits of microseconds, as a microcontroller's clock counts them; the count
// wraps every 71.6 minutes. Ports include it for `now()`, programs for time limits and periods.
//
//     constexpr instant before{0xFFFF'FFF0u}, later{0x10};
//     static_assert(since(before, later) == microseconds(32)); // across the wrap
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus {

/// A length of time, 0 .. 35.79 minutes (2^31 us).
struct duration {
    std::uint32_t us = 0;

    constexpr duration() = default;
    /// By name: `duration{20}` is 20 us. A bare number for a time does not compile; `milliseconds(20)` says its unit.
    constexpr explicit duration(std::uint32_t microseconds) : us{microseconds} {}

    // Written out: for a defaulted <=> GCC emits a separate function at -Os.
    friend constexpr bool operator==(duration a, duration b) { return a.us == b.us; }
    friend constexpr bool operator<(duration a, duration b) { return a.us < b.us; }
    friend constexpr bool operator>(duration a, duration b) { return a.us > b.us; }
    friend constexpr bool operator<=(duration a, duration b) { return a.us <= b.us; }
    friend constexpr bool operator>=(duration a, duration b) { return a.us >= b.us; }
    friend constexpr duration operator+(duration a, duration b) { return duration{a.us + b.us}; }
    friend constexpr duration operator-(duration a, duration b) { return duration{a.us - b.us}; }
    friend constexpr duration operator*(duration a, std::uint32_t n) { return duration{a.us * n}; }
};

constexpr duration microseconds(std::uint32_t n) { return duration{n}; }
constexpr duration milliseconds(std::uint32_t n) { return duration{n * 1000u}; }
constexpr duration longer_of(duration a, duration b) { return duration{a.us < b.us ? b.us : a.us}; }
constexpr duration shorter_of(duration a, duration b) { return duration{b.us < a.us ? b.us : a.us}; }

/// A reading of the port's clock. Only differences are meaningful; the clock may wrap.
struct instant {
    std::uint32_t us = 0;

    friend constexpr bool operator==(instant, instant) = default;
    friend constexpr instant operator+(instant t, duration d) { return {t.us + d.us}; }
};

/// Time from `then` to `now`, modulo the clock's wrap of 71.6 minutes.
constexpr duration since(instant then, instant now) { return duration{now.us - then.us}; }

/// True if `now` reads as earlier than `then`: the clock jumped back, or more than 35 minutes have passed.
constexpr bool went_back(instant then, instant now) { return (since(then, now).us & 0x8000'0000u) != 0; }

} // namespace servobus
