// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Describes any frame in one line of text: registers, values with their units, the device's meaning of an
// exception number, what is wrong with a frame. Programs include it for logs, captures and tools. It needs
// the device's catalogue and no heap.
//
//     constexpr auto line = [] {
//         std::array<char, 80> room{};
//         explain(zlac8015d::catalogue, direction::request, modbus::write_frame(1, 0x2080, 500), room);
//         return room; // "node 1: write left_acceleration_time (0x2080) = 500 ms"
//     }();
//
// Other lines:
//
//   node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min
//   node 1: response, exception 2 (illegal data address) to read unknown register (0x3000)
//   node 1: response, coils 0x0013..0x001C = 11001101 01
//   node 1: write valve (0x0003) = open (0x0001)
//   node 1: valid frame of function 65h (user-defined), data 01
#pragma once

#include <servobus/core/cxx20.hpp>

#include <span>

#include <servobus/explain/detail/explainer.hpp>
#include <servobus/explain/explanation.hpp>
#include <servobus/explain/table_catalogues.hpp>
#include <servobus/registers/catalogue.hpp>

namespace servobus {

/// Describes `frame` in one line of text, which it writes into `out` without a terminating zero. `request` is
/// the frame to which a response may belong; a read response has register names only with its request.
/// `order` is the word order of 32-bit values; `unknown` selects that of the profile or, if the drive
/// can switch it, the factory setting; the text then has a note. Of a function that `is_of_known_function` does not
/// know, a frame is valid if its CRC is; the text has its data in hex. A frame of function 01, 02 or 17h that is
/// well-formed in both directions is a response if it fits `request`, else a request.
/// Errors, in `why`: `too_short`, `too_long`, `bad_crc`, `wrong_function` (00, or a request with the flag of an
/// exception), `wrong_byte_count`, `wrong_quantity`, `wrong_value`, `unexpected_value` (content that the standard does
/// not allow), `wrong_address` (beyond 0xFFFF), `wrong_node` (a response from address 0), `bad_argument` (a broadcast
/// read).
constexpr explanation explain(const catalogue& map, direction way, bytes frame, bytes request,
                              std::span<char> out, word_order order = word_order::unknown) {
    return detail::explainer{table_catalogues{&map}, order, out}.explain(way, frame, request);
}

/// The same without a request.
constexpr explanation explain(const catalogue& map, direction way, bytes frame, std::span<char> out) {
    return explain(map, way, frame, bytes{}, out);
}

/// The same with names for coils, discrete inputs and input registers too.
constexpr explanation explain(const table_catalogues& maps, direction way, bytes frame, bytes request,
                              std::span<char> out, word_order order = word_order::unknown) {
    return detail::explainer{maps, order, out}.explain(way, frame, request);
}

} // namespace servobus
