// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Looks whether a device responds at an address. One read that changes nothing tells no response, a
// response and a collision apart. Tools that scan a line include it; so does client/change_address.hpp.
// Any frame restarts the watchdog of a drive whose controller has failed: its motors may run on.
//
//     for (std::uint8_t address = 1; address <= 247; ++address) {
//         const finding found = look_for(wire, address, {.response = milliseconds(50)});
//         if (found.what == presence::present) std::printf("node %d responds\n", address);
//     }
#pragma once

#include <array>
#include <cstdint>

#include <servobus/line/line.hpp>

namespace servobus {

enum class presence : std::uint8_t {
    no_response, ///< nothing came, or a gateway's exception: it got no response
    present,     ///< a valid response, an exception of the device too
    garbled, ///< bytes came that are no response, each time: two devices at one address, or another baud rate
    failed,  ///< the port or the line failed
};

/// The answer of an address. `word` is the content of the register that was read, if `has_word`.
struct finding {
    presence what = presence::no_response;
    bool has_word = false;
    std::uint16_t word = 0;
    status why{};
};

/// Reads the register at `address` of the node at `node_address`, a second time if what comes is no valid
/// response. Blocking; returns within twice `line::bound` for a read of one register. After no response it
/// waits for no quarantine: the next request goes to another node, which ignores a late response.
template <class Line>
constexpr finding look_for(Line& on, std::uint8_t node_address, const response_limits& limits,
                           std::uint16_t address = 0) {
    const modbus::frame<8> request = modbus::read_frame<typename Line::crc>(node_address, address, 1);
    finding found;
    for (int attempt = 0; attempt < 2; ++attempt) {
        std::array<std::uint8_t, 7> response{};
        modbus::exchange x{request, response, on.timing(), limits};
        on.run(x, {});
        found.why = x.status();
        if (x.status().error() == errc::ok) return {presence::present, true, x.words()[0], {}};
        if (x.status().has_response()) return {presence::present, false, 0, x.status()};
        if (x.status().error() == errc::gateway_exception) return found; // the gateway got no response
        // A garbled character is what two devices, or another baud rate, look like to a UART.
        if (x.status().error() < errc::no_echo && x.status().error() != errc::receive_failed)
            return {presence::failed, false, 0, x.status()};
        // A timeout too: bytes of another node, or that were ignored until a gap, may have come.
        if (x.status().error() == errc::timeout && !x.has_received()) return found;
    }
    found.what = found.why.error() == errc::no_echo ? presence::failed : presence::garbled;
    return found;
}

} // namespace servobus
