// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Frames of Modbus TCP in a log: a header of seven bytes in front of unit and PDU, and no CRC.
//
//     00 01 00 00 00 06 01 03 00 0A 00 02     transaction 1, unit 1: read two registers
#pragma once

#include <cstdint>
#include <vector>

#include <servobus/explain/direction.hpp>
#include <servobus/modbus/rtu.hpp>

namespace tool {

/// `offset`: of its first byte among those of the line. `rtu`: the same request or response with a CRC.
struct tcp_frame {
    std::uint16_t transaction = 0;
    std::uint8_t unit = 0;
    std::size_t offset = 0;
    std::size_t size = 0;
    std::vector<std::uint8_t> rtu{};
};

namespace detail {

inline constexpr std::size_t tcp_header = 6; ///< with the length, before the unit

// The size of the frame at the beginning of `from`; 0 if none begins there. A header alone proves nothing, so the PDU
// must be one of a known function and have two bytes: a damaged RTU frame may look like a header and one byte.
inline std::size_t tcp_size_at(servobus::bytes from) {
    if (from.size() < tcp_header + 3 || servobus::load_word(from, 2) != 0) return 0;
    const std::size_t size = tcp_header + servobus::load_word(from, 4);
    if (size < tcp_header + 3 || size > tcp_header + 254 || size > from.size()) return 0;
    const servobus::bytes pdu = from.subspan(tcp_header + 1, size - tcp_header - 1);
    return servobus::is_request(pdu) || servobus::is_response(pdu) ? size : 0;
}

} // namespace detail

/// The frames of Modbus TCP of which `all` consists; none if there is anything else in it.
inline std::vector<tcp_frame> tcp_frames_of(servobus::bytes all) {
    std::vector<tcp_frame> found;
    for (std::size_t at = 0; at < all.size();) {
        const servobus::bytes rest = all.subspan(at);
        const std::size_t size = detail::tcp_size_at(rest);
        if (size == 0) return {};
        const servobus::bytes pdu = rest.subspan(detail::tcp_header + 1, size - detail::tcp_header - 1);
        tcp_frame one{servobus::load_word(rest, 0), rest[detail::tcp_header], at, size, {}};
        // Units 0 and 248..255 are the device at the other end itself: as any node's, since 0 is no broadcast there.
        one.rtu.push_back(servobus::modbus::is_node_address(one.unit) ? one.unit : std::uint8_t{1});
        one.rtu.insert(one.rtu.end(), pdu.begin(), pdu.end());
        one.rtu.resize(one.rtu.size() + 2);
        (void)servobus::modbus::close_frame(one.rtu, pdu.size());
        found.push_back(std::move(one));
        at += size;
    }
    return found;
}

} // namespace tool
