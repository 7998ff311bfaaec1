// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: exact arithmetic of 128 bits for constants, without a type of 128 bits. Scales and axles are computed with
// it by the compiler. A program contains none of it.
//
//     static_assert(detail::floor_of(1'000'000'000'000, 3'000'000'000'000, 7'000'000'000) == 428'571'428'571'428);
//     static_assert(detail::greatest_divisor(16384, 652'300) == 4);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::detail {

/// The greatest common divisor; of 0 and `b` it is `b`.
constexpr std::uint64_t greatest_divisor(std::uint64_t a, std::uint64_t b) {
    while (b != 0) {
        const std::uint64_t r = a % b;
        a = b;
        b = r;
    }
    return a;
}

/// floor(a * b / c), modulo 2^64, by long division. 0 < c <= 2^63.
constexpr std::uint64_t floor_of(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    constexpr std::uint64_t half = 0xFFFF'FFFFu;
    const std::uint64_t cross = (a & half) * (b & half);
    const std::uint64_t left = (a >> 32) * (b & half);
    const std::uint64_t right = (a & half) * (b >> 32);
    const std::uint64_t middle = (cross >> 32) + (left & half) + (right & half);
    std::uint64_t low = (cross & half) | middle << 32;
    std::uint64_t high = (a >> 32) * (b >> 32) + (left >> 32) + (right >> 32) + (middle >> 32);
    std::uint64_t rest = 0;
    std::uint64_t quotient = 0;
    for (int i = 0; i < 128; ++i) {
        rest = rest << 1 | high >> 63;
        high = high << 1 | low >> 63;
        low <<= 1;
        quotient <<= 1;
        if (rest >= c) {
            rest -= c;
            quotient |= 1;
        }
    }
    return quotient;
}

/// The whole number nearest to a * b / c; halves are rounded up. 0 < c <= 2^62, and the result is below 2^63.
constexpr std::uint64_t nearest_of(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    return (floor_of(a, 2 * b, c) + 1) / 2; // b < 2^63
}

} // namespace servobus::detail
