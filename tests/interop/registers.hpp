// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What both servers have at the start and both clients expect, at node 17: 200 holding and as many input registers from
// 0x2000 on, 17 coils from 0x0010 on, 11 discrete inputs from 0x0040 on. tables.py has the same for
// peers in Python.
#pragma once

#include <cstdint>

namespace interop {

inline constexpr std::uint8_t node_address = 17;
inline constexpr unsigned first = 0x2000;
inline constexpr unsigned count = 200;
inline constexpr unsigned first_coil = 0x0010;
inline constexpr unsigned coils = 17;
inline constexpr unsigned first_input = 0x0040;
inline constexpr unsigned inputs = 11;
inline constexpr std::uint32_t baud = 115200;

/// The value of a register at the start.
constexpr std::uint16_t initial(unsigned address) {
    return static_cast<std::uint16_t>(address * 40503u >> 3 & 0xFFFFu);
}
/// The value of a coil or a discrete input at the start.
constexpr bool initial_bit(unsigned address) { return address % 3 == 0; }

} // namespace interop
