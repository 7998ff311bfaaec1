// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What both servers hold at the start and both clients expect: 200 registers from 0x2000 on, unit 17.
#pragma once

#include <cstdint>

namespace interop {

inline constexpr std::uint8_t unit = 17;
inline constexpr unsigned first = 0x2000;
inline constexpr unsigned count = 200;
inline constexpr std::uint32_t baud = 115200;

/// What a register holds at the start.
constexpr std::uint16_t initial(unsigned address) {
    return static_cast<std::uint16_t>(address * 40503u >> 3 & 0xFFFFu);
}

} // namespace interop
