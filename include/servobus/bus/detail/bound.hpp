// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An upper bound of a time that a plan computes.
#pragma once

#include <cstdint>

#include <servobus/core/time.hpp>

namespace servobus::detail {

/// A duration whose sums and products end at the longest that there is, instead of beginning again.
struct bound {
    duration time{};

    constexpr bound(duration d) : time{d} {} // NOLINT: a term of a sum
    constexpr operator duration() const { return time; }
    friend constexpr bound operator+(bound a, duration b) { return at_most(std::uint64_t{a.time.us} + b.us); }
    friend constexpr bound operator+(bound a, bound b) { return a + b.time; }
    friend constexpr bound operator*(bound a, std::uint32_t n) {
        return at_most(std::uint64_t{a.time.us} * n);
    }
    static constexpr bound at_most(std::uint64_t us) {
        return duration{us < 0xFFFF'FFFFu ? static_cast<std::uint32_t>(us) : 0xFFFF'FFFFu};
    }
};

} // namespace servobus::detail
