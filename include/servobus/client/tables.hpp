// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client reads and writes rows of all four tables, and calls functions 16h and 17h. any_device.hpp includes it.
//
//     const auto now = io.read<tank::level, tank::temperature, tank::valve>(); // io: a client of a tank
//     if (now && now->get<tank::level>() > 900 && !io.write<tank::valve>(true)) return 1;
//     if (!io.change_bits<tank::options, 0x000C>(0x0004)) return 1;
//     const auto after = io.write_then_read<rows<tank::state>, tank::ramp>(500 * millisecond);
#pragma once

#include <servobus/client/client.hpp>
#include <servobus/client/detail/table_calls.hpp>
#include <servobus/client/stepped_tables.hpp>

namespace servobus {

// For generic code, as those of client/free_calls.hpp.

/// `c.change_bits<R, Mask>(value)`
template <const auto& R, u16 Mask, class Line, class Device, class Node>
constexpr status change_bits(client<Line, Device, Node>& c, u16 value) {
    return c.template change_bits<R, Mask>(value);
}
/// `c.write_then_read<Reads, Ws...>(values...)`
template <class Reads, const auto&... Ws, class Line, class Device, class Node>
constexpr auto write_then_read(client<Line, Device, Node>& c, register_value<Ws>... values) {
    return c.template write_then_read<Reads, Ws...>(values...);
}

} // namespace servobus
