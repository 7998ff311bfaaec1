// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames of other nodes on the line, with all functions that are in use and one that a vendor has made (G11, G14, G41).
// The payload of a carrier contains a valid frame of this program's node, which nothing on the line may take for one
// (G6).
#pragma once

#include <cstddef>
#include <cstdint>

#include "played.hpp"
#include "timed_sender.hpp"

namespace trial {

/// The end of this frame follows from its function and its counts (G41).
constexpr bool has_known_length(neighbour n) {
    return n != neighbour::server_id && n != neighbour::user_defined && n != neighbour::carrier;
}

/// A response of node `from`, or a broadcast. `carried`: the frame in the payload of a carrier.
inline byte_list frame_of(scene& on, neighbour what, std::uint8_t from, servobus::bytes carried) {
    byte_list f{what == neighbour::broadcast ? std::uint8_t{0} : from};
    const auto add = [&](std::size_t n) {
        for (std::size_t i = 0; i < n; ++i) f.push_back(on.any_byte());
    };
    const auto counted = [&](std::uint8_t function, std::uint32_t most) {
        const std::uint32_t n = 2 * on.between(1, most);
        f.insert(f.end(), {function, static_cast<std::uint8_t>(n)});
        add(n);
    };
    switch (what) {
    case neighbour::read_coils: counted(0x01, 6); break;
    case neighbour::read_inputs: counted(0x02, 6); break;
    case neighbour::read_holding: counted(0x03, 8); break;
    case neighbour::read_write: counted(0x17, 8); break;
    case neighbour::server_id: counted(0x11, 8); break;
    case neighbour::write_word:
        f.push_back(0x06);
        add(4);
        break;
    case neighbour::write_words:
    case neighbour::write_coils:
        f.push_back(what == neighbour::write_words ? 0x10 : 0x0F);
        add(2);
        f.insert(f.end(), {0x00, static_cast<std::uint8_t>(on.between(1, 100))});
        break;
    case neighbour::mask_write:
        f.push_back(0x16);
        add(6);
        break;
    // Devices on this line execute none of function 05.
    case neighbour::write_coil:
    case neighbour::broadcast:
        f.push_back(0x05);
        add(2);
        f.insert(f.end(), {0xFF, 0x00});
        break;
    case neighbour::carrier:
        f.push_back(0x65);
        add(on.between(0, 4));
        f.insert(f.end(), carried.begin(), carried.end());
        add(on.between(0, 4));
        break;
    default: f.push_back(0x65); add(on.between(1, 20));
    }
    return closed(f);
}
inline neighbour any_neighbour(scene& on) {
    return static_cast<neighbour>(on.random.below(static_cast<std::uint32_t>(neighbour::count_)));
}
/// A response that differs from this one in its last data byte, with a valid CRC.
inline byte_list altered(servobus::bytes response) {
    byte_list f{response.begin(), response.end()};
    f.resize(f.size() - 2);
    f.back() ^= 0x15;
    return closed(f);
}

} // namespace trial
