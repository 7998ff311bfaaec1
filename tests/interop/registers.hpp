// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers that both servers have at the start and both clients expect: 200 from 0x2000 on, node 17.
#pragma once

#include <cstdint>

namespace interop {

inline constexpr std::uint8_t node_address = 17;
inline constexpr unsigned first = 0x2000;
inline constexpr unsigned count = 200;
inline constexpr std::uint32_t baud = 115200;

/// The value of a register at the start.
constexpr std::uint16_t initial(unsigned address) {
    return static_cast<std::uint16_t>(address * 40503u >> 3 & 0xFFFFu);
}

} // namespace interop
