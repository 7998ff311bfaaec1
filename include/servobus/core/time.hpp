// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Time as a microcontroller has it: 32 bits of microseconds that wrap every 71.6 minutes.
#pragma once

#include <cstdint>

namespace servobus {

/// A span of time, 0 .. 35.79 minutes (2^31 us).
struct duration {
    std::uint32_t us = 0;

    // One by one: of a defaulted <=> GCC makes a function of its own at -Os.
    friend constexpr bool operator==(duration a, duration b) { return a.us == b.us; }
    friend constexpr bool operator<(duration a, duration b) { return a.us < b.us; }
    friend constexpr bool operator>(duration a, duration b) { return a.us > b.us; }
    friend constexpr bool operator<=(duration a, duration b) { return a.us <= b.us; }
    friend constexpr bool operator>=(duration a, duration b) { return a.us >= b.us; }
    friend constexpr duration operator+(duration a, duration b) { return {a.us + b.us}; }
    friend constexpr duration operator-(duration a, duration b) { return {a.us - b.us}; }
    friend constexpr duration operator*(duration a, std::uint32_t n) { return {a.us * n}; }
};

constexpr duration microseconds(std::uint32_t n) { return {n}; }
constexpr duration milliseconds(std::uint32_t n) { return {n * 1000u}; }
constexpr duration longer_of(duration a, duration b) { return {a.us < b.us ? b.us : a.us}; }
constexpr duration shorter_of(duration a, duration b) { return {b.us < a.us ? b.us : a.us}; }

/// A reading of the port's clock. Only differences have a meaning; the clock may wrap.
struct instant {
    std::uint32_t us = 0;

    friend constexpr bool operator==(instant, instant) = default;
    friend constexpr instant operator+(instant t, duration d) { return {t.us + d.us}; }
};

/// Time from `then` to `now`, whatever wraps lie between.
constexpr duration since(instant then, instant now) { return {now.us - then.us}; }

/// True if the clock seems to stand before `then`: it jumped back, or more than 35 minutes have passed.
constexpr bool went_back(instant then, instant now) { return (since(then, now).us & 0x8000'0000u) != 0; }

} // namespace servobus
