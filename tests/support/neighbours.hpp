// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames of other nodes, of every function of the standard that states its lengths and of some that state
// none. The forms are written here a second time, from the standard (Modbus Application Protocol V1.1b3,
// section 6).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "scripted_port.hpp"

namespace tests::neighbours {

/// The functions that are played; the last ones have frames of any length.
inline constexpr std::array<std::uint8_t, 15> functions{0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F, 0x10,
                                                        0x16, 0x17, 0x07, 0x14, 0x2B, 0x41, 0x65};
inline constexpr bool has_length(std::uint8_t code) {
    return code <= 0x06 || code == 0x0F || code == 0x10 || code == 0x16 || code == 0x17;
}

/// A request and the response to it. `payload` is in one of them, or in both, where the function has one. It
/// is cut or filled up as its byte count wants.
struct pair {
    byte_list request;
    byte_list response;
};

inline byte_list filled(byte_list payload, std::size_t size, dice& random) {
    while (payload.size() < size) payload.push_back(random.byte());
    payload.resize(size);
    return payload;
}

inline pair pair_of(std::uint8_t node_address, std::uint8_t code, const byte_list& payload, dice& random) {
    const byte_list head{node_address, code};
    const byte_list place{random.byte(), random.byte()};
    const auto size = static_cast<std::uint32_t>(payload.size());
    const auto word = [](std::uint32_t value) { return byte_list{high_byte(value), low_byte(value)}; };
    const std::uint32_t registers = std::min<std::uint32_t>(120, (size + 1) / 2 + 1 + random.below(8));
    const byte_list words = filled(payload, 2 * registers, random);
    switch (code) {
    case 0x01:
    case 0x02: {
        const std::uint32_t bits = 8 * size + 1 + random.below(80);
        const std::uint32_t count = (bits + 7) / 8;
        return {framed(head + place + word(bits)),
                framed(head + byte_list{low_byte(count)} + filled(payload, count, random))};
    }
    case 0x03:
    case 0x04:
        return {framed(head + place + word(registers)),
                framed(head + byte_list{low_byte(2 * registers)} + words)};
    case 0x05:
    case 0x06: {
        const byte_list one = framed(head + place + byte_list{random.byte(), random.byte()});
        return {one, one};
    }
    case 0x0F: {
        const std::uint32_t bits = 8 * size + 1 + random.below(80);
        const std::uint32_t count = (bits + 7) / 8;
        return {
            framed(head + place + word(bits) + byte_list{low_byte(count)} + filled(payload, count, random)),
            framed(head + place + word(bits))};
    }
    case 0x10:
        return {framed(head + place + word(registers) + byte_list{low_byte(2 * registers)} + words),
                framed(head + place + word(registers))};
    case 0x16: {
        const byte_list one = framed(head + place + filled({}, 4, random));
        return {one, one};
    }
    case 0x17: {
        const std::uint32_t read = 1 + random.below(60);
        return {framed(head + place + word(read) + place + word(registers) +
                       byte_list{low_byte(2 * registers)} + words),
                framed(head + byte_list{low_byte(2 * read)} + filled(payload, 2 * read, random))};
    }
    case 0x07: return {framed(head), framed(head + byte_list{random.byte()})};
    default:
        return {framed(head + payload + filled({}, random.below(9), random)),
                framed(head + filled({}, random.below(9), random) + payload)};
    }
}

} // namespace tests::neighbours
