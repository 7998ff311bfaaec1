// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lengths of frames in a stream of bytes, as their functions and their own bytes give them.
#pragma once

#include <cstddef>

#include <servobus/core/bytes.hpp>
#include <servobus/modbus/growing_response.hpp>
#include <servobus/modbus/rtu.hpp>

namespace tool {

using servobus::modbus::max_frame;
using servobus::modbus::min_frame;

/// True if a whole frame of `size` bytes begins with `from`.
inline bool is_whole(servobus::bytes from, std::size_t size) {
    return size >= min_frame && size <= max_frame && size <= from.size() &&
           servobus::modbus::crc16(from.first(size)) == 0;
}
inline servobus::bytes pdu_of(servobus::bytes from, std::size_t size) { return from.subspan(1, size - 3); }

/// A loopback test has as many words as its client likes: the CRC tells where it ends. 8 if it fits nowhere.
inline std::size_t loopback_size(servobus::bytes from) {
    constexpr std::size_t shortest = 8;
    for (std::size_t size = shortest; size <= from.size() && size <= max_frame; size += 2) {
        if (is_whole(from, size)) return size;
    }
    return shortest;
}
inline bool is_loopback(servobus::bytes from) {
    return from[1] == 0x08 && from.size() >= min_frame && servobus::load_word(from, 2) == 0;
}

/// The length of the request that begins with `from`, at least two bytes; 0 if these are too few, or the function is
/// none of the standard.
inline std::size_t request_size(servobus::bytes from) {
    switch (from[1]) {
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11: return 4;
    case 0x08: return is_loopback(from) ? loopback_size(from) : 8;
    case 0x18: return 6;
    case 0x2B: return 7;
    default: return servobus::modbus::request_length(from);
    }
}

/// The length of the response that begins with `from`, at least three bytes; 0 if the function is none of the standard.
/// Longer than `from` while its bytes do not give the length yet.
inline std::size_t response_size(servobus::bytes from) {
    if ((from[1] & servobus::modbus::exception_flag) != 0) return 5;
    if (is_loopback(from)) return loopback_size(from);
    const bool has_length =
        servobus::modbus::response_length(from[1], from[2]) != 0 || request_size(from) != 0;
    if (!has_length) return 0;
    const servobus::bytes pdu = from.subspan(1);
    servobus::modbus::growing_response growing{pdu.first(1)}; // of the request its code is enough
    return growing.least_length(pdu) + 3;
}

} // namespace tool
