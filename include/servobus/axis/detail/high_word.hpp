// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: the upper 32 bits of a product, as quickly as the core can. A core without a multiplication of 64 bits
// calls a function of 43 instructions for one; by parts it takes 19.
//
//     static_assert(detail::high_word(0x8000'0000, 6) == 3);
//     static_assert(detail::high_word_by_parts(0xFFFF'FFFF, 0xFFFF'FFFF) == 0xFFFF'FFFE);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::detail {

// Thumb without Thumb-2: Cortex-M0, M0+, M1, M23.
#if defined(__thumb__) && !defined(__thumb2__)
inline constexpr bool has_long_multiply = false;
#else
inline constexpr bool has_long_multiply = true;
#endif

/// floor(a * b / 2^32) by four products of 32 bits.
constexpr std::uint32_t high_word_by_parts(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t a_low = a & 0xFFFFu;
    const std::uint32_t a_high = a >> 16;
    const std::uint32_t b_low = b & 0xFFFFu;
    const std::uint32_t b_high = b >> 16;
    const std::uint32_t left = a_high * b_low + (a_low * b_low >> 16);
    const std::uint32_t right = a_low * b_high + (left & 0xFFFFu);
    return a_high * b_high + (left >> 16) + (right >> 16);
}

/// floor(a * b / 2^32)
constexpr std::uint32_t high_word(std::uint32_t a, std::uint32_t b) {
    if constexpr (has_long_multiply) return static_cast<std::uint32_t>(std::uint64_t{a} * b >> 32);
    return high_word_by_parts(a, b);
}

} // namespace servobus::detail
