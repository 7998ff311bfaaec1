// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The values that a server of another library has, each as its own functions encode it, in both word orders. A client
// writes others into the block behind them.
#pragma once

#include <cstdint>

namespace interop {

inline constexpr unsigned high_first_block = 0x0100,
                          low_first_block = 0x0200; // the words of each value in this order
inline constexpr unsigned written_behind = 0x0040;  // from a block to what is written
inline constexpr unsigned f32_at = 0, f64_at = 2, u32_at = 6, i32_at = 8, u64_at = 10, i64_at = 14,
                          swapped_at = 18, text_at = 20, words = 24;

struct value_set {
    float f32;
    double f64;
    std::uint32_t u32;
    std::int32_t i32;
    std::uint64_t u64;
    std::int64_t i64;
    float swapped; // the low byte of each word first
    const char* text;
};
inline constexpr value_set read_values{230.1f, -12.5e-30, 4'000'000'001u, -70'000, 0x8001'0002'0003'0004u,
                                       -5,     -0.75f,    "SDM120"};
inline constexpr value_set written_values{-1.5e-7f,       3.25, 65'537u, -1, 0x0001'0000'0000'0002u,
                                          -9'000'000'000, 1e9f, "hall 3"};

} // namespace interop
