// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lengths of frames in a stream of bytes, as their functions and their own bytes give them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

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

/// Return Query Data has as many words as its client likes: the CRC tells where it ends. 8 if it fits nowhere.
inline std::size_t query_data_size(servobus::bytes from) {
    constexpr std::size_t shortest = 8;
    for (std::size_t size = shortest; size <= from.size() && size <= max_frame; size += 2) {
        if (is_whole(from, size)) return size;
    }
    return shortest;
}
inline bool is_return_query_data(servobus::bytes from) {
    return from[1] == 0x08 && from.size() >= min_frame && servobus::load_word(from, 2) == 0;
}

/// True if the bytes of the frame that begins with `from`, at least two, give its length: by its function, and not of
/// another encapsulated interface than the identification, nor of a Return Query Data request whose CRC fits nowhere.
inline bool has_length(servobus::bytes from) {
    constexpr std::uint8_t codes[] = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x0B,
                                      0x0C, 0x0F, 0x10, 0x11, 0x16, 0x17, 0x18, 0x2B};
    const auto code = static_cast<std::uint8_t>(from[1] & 0x7Fu);
    if (std::find(std::begin(codes), std::end(codes), code) == std::end(codes)) return false;
    if (from[1] == 0x2B && from.size() > 2) return from[2] == 0x0E;
    return !is_return_query_data(from) || from.size() < 8 || is_whole(from, query_data_size(from));
}

/// False if the counts of a request contradict each other, as far as `from` has them.
inline bool may_be_request(servobus::bytes from) {
    const std::size_t count_at = from[1] == 0x17 ? 10 : from[1] == 0x0F || from[1] == 0x10 ? 6 : 0;
    if (count_at == 0 || from.size() <= count_at) return true;
    const std::size_t quantity = servobus::load_word(from, count_at - 2);
    const std::size_t size = from[1] == 0x0F ? (quantity + 7) / 8 : 2 * quantity;
    return size != 0 && from[count_at] == size;
}

/// False if no response begins so, as far as `from` has its counts.
inline bool may_be_response(servobus::bytes from) {
    if (from[0] == servobus::modbus::broadcast) return false;
    if (from.size() < 3) return true;
    constexpr unsigned most = 2 * servobus::modbus::max_read;
    const unsigned count = from[2];
    switch (from[1]) {
    case 0x01:
    case 0x02: return count >= 1 && count <= most;
    case 0x03:
    case 0x04:
    case 0x17: return count >= 2 && count <= most && count % 2 == 0;
    case 0x0C: return count >= 6 && count <= 6 + 64; // status, two counters, events
    case 0x11: return count >= 1 && count <= most;
    case 0x18: return count == 0 && (from.size() < 4 || (from[3] >= 2 && from[3] <= 2 + 2 * 31));
    case 0x2B: return from.size() < 5 || ((from[4] & 0x7Fu) >= 1 && (from[4] & 0x7Fu) <= 3); // conformity
    }
    return true;
}

/// The length of the request that begins with `from`, at least two bytes; 0 if these are too few, or the function is
/// none of the standard.
inline std::size_t request_size(servobus::bytes from) {
    switch (from[1]) {
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11: return 4;
    case 0x08: return is_return_query_data(from) ? query_data_size(from) : 8;
    case 0x18: return 6;
    case 0x2B: return 7;
    default: return servobus::modbus::request_length(from);
    }
}

/// The length of the response that begins with `from`, at least three bytes; 0 if the function is none of the standard.
/// Longer than `from` while its bytes do not give the length yet.
inline std::size_t response_size(servobus::bytes from) {
    if ((from[1] & servobus::modbus::exception_flag) != 0) return 5;
    if (is_return_query_data(from)) return query_data_size(from);
    const bool has_length =
        servobus::modbus::response_length(from[1], from[2]) != 0 || request_size(from) != 0;
    if (!has_length) return 0;
    const servobus::bytes pdu = from.subspan(1);
    servobus::modbus::growing_response growing{pdu.first(1)}; // of the request its code is enough
    return growing.least_length(pdu) + 3;
}

} // namespace tool
