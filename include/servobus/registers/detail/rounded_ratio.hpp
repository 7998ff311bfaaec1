// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Multiplies, scales by a power of two and divides, exact and without a division: a small core has none for 64 bits.
//
//     static_assert(detail::rounded_ratio(5, 1, 2) == 3 && detail::rounded_ratio(5, 1, 2, -1) == 1); // 2.5 and 1.25
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::detail {

inline constexpr std::uint32_t most_of_ratio = std::uint32_t{1} << 31;

/// `value * numerator * 2^exponent / denominator`, rounded to the nearest, halves up, and limited to 2^31. The
/// denominator is below 2^60, and below 2^30 unless `exponent` is 0.
constexpr std::uint32_t rounded_ratio(std::uint64_t value, std::uint32_t numerator, std::uint64_t denominator,
                                      int exponent = 0) {
    for (; exponent > 0 && value != 0; --exponent) {
        if (value >> 63 != 0) return most_of_ratio;
        value <<= 1;
    }
    // The product has 96 bits.
    const std::uint64_t low = (value & 0xFFFF'FFFFu) * numerator;
    std::uint64_t high = (value >> 32) * numerator + (low >> 32);
    std::uint32_t rest = static_cast<std::uint32_t>(low);
    // An even denominator rounds alike whatever the bits below 1 are, so they may be dropped.
    for (; exponent < -29; ++exponent) {
        rest = rest >> 1 | static_cast<std::uint32_t>(high) << 31;
        high >>= 1;
    }
    for (; exponent < 0; ++exponent) denominator <<= 1;
    std::uint64_t remainder = 0;
    std::uint32_t quotient = 0;
    for (unsigned i = 0; i < 96; ++i) {
        if (quotient >= most_of_ratio) return most_of_ratio;
        remainder = remainder << 1 | high >> 63;
        high = high << 1 | rest >> 31;
        rest <<= 1;
        quotient <<= 1;
        if (remainder < denominator) continue;
        remainder -= denominator;
        ++quotient;
    }
    if (remainder >= denominator - denominator / 2 && quotient < most_of_ratio) ++quotient;
    return quotient < most_of_ratio ? quotient : most_of_ratio;
}

/// With a sign, limited to 32 bits.
constexpr std::int32_t signed_ratio(bool is_negative, std::uint32_t magnitude) {
    if (is_negative) return static_cast<std::int32_t>(std::uint32_t{0} - magnitude);
    return magnitude == most_of_ratio ? 0x7FFF'FFFF : static_cast<std::int32_t>(magnitude);
}

} // namespace servobus::detail
