// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a request alone says of its response: the length, and which bytes are fixed. The headers that gather responses
// include it.
//
//     constexpr auto request = hex("11 01 00 13 00 25 0E 84"); // reads 37 coils
//     static_assert(modbus::expected_response(request) == 10 && modbus::has_count(modbus::like(0x01)));
//
// Source: Modbus Application Protocol V1.1b3, section 6.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

inline constexpr std::uint8_t like_none = 0xFF; ///< only the function of the response is known

/// The function whose response is judged alike. A response to 01..04 has a byte count, as that to 17h. All others that
/// are named here repeat their request, whole or its first six bytes.
constexpr std::uint8_t like(std::uint8_t code) {
    constexpr std::uint32_t themselves = 0x0041'807E; // a bit each for 01..06, 0F, 10h and 16h
    if (code < 32 && (themselves >> code & 1u) != 0) return code;
    return code == 0x17 ? std::uint8_t{0x03} : like_none;
}
/// True for Return Query Data, function 08h with sub-function 0, whose response repeats it.
constexpr bool is_return_query_data(bytes request) {
    return request[1] == 0x08 && request.size() >= 8 && load_word(request, 2) == 0;
}
/// True for the functions 01..04, in whose response the third byte counts those that follow.
constexpr bool has_count(std::uint8_t like) { return like <= 0x04; }
/// True if a response that repeats its request has a value at the place of a quantity.
constexpr bool repeats_a_value(std::uint8_t like) { return like != 0x0F && like != 0x10; }

/// True for a request PDU of the standard that changes nothing in a device. It is not empty.
constexpr bool only_reads(bytes pdu) {
    switch (pdu[0]) {
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11:
    case 0x18: return true;
    case 0x2B: return pdu.size() > 1 && pdu[1] == 0x0E; // other MEI types may write
    }
    return pdu[0] <= 0x04;
}

inline constexpr std::uint16_t any_length = 0xFFFF; ///< a request does not say how long its response is

/// The length of the response frame to `request`, a frame of function 03, 04, 06 or 10h; 0 if the length or the
/// quantity of the request is wrong.
constexpr std::uint16_t expected_register_response(bytes request) {
    if (is_read(request[1])) {
        const bool whole =
            request.size() == 8 && request[4] == 0 && request[5] >= 1 && request[5] <= max_read;
        return whole ? static_cast<std::uint16_t>(5 + 2 * request[5]) : std::uint16_t{0};
    }
    // A response to 06 repeats its request including the CRC, so a request of 06 has 8 bytes.
    return request.size() == 8 || (request.size() > 8 && request[1] != 0x06) ? 8 : 0;
}

/// The same for any function: `any_length` for those other than 01..06, 0F, 10h, 16h, 17h and Return Query Data (08h
/// with sub-function 0).
constexpr std::uint16_t expected_response(bytes request) {
    const std::size_t size = request.size();
    const std::uint8_t code = request[1];
    if (is_read(code) || is_write(code)) return expected_register_response(request);
    switch (code) {
    case 0x01:
    case 0x02:
    case 0x17: {
        const bool is_bits = code != 0x17;
        if (is_bits ? size != 8 : size < 13) return 0;
        const std::uint16_t quantity = load_word(request, 4);
        if (quantity == 0 || quantity > (is_bits ? 2000 : max_read)) return 0;
        return static_cast<std::uint16_t>(5 + (is_bits ? (quantity + 7) / 8 : 2 * quantity));
    }
    case 0x05: return size == 8 ? 8 : 0;
    case 0x0F: return size >= 10 ? 8 : 0;
    case 0x16: return size == 10 ? 10 : 0;
    }
    return is_return_query_data(request) ? static_cast<std::uint16_t>(size) : any_length;
}

} // namespace servobus::modbus
