// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Looks whether a device responds at an address. One read, which changes nothing, distinguishes no response, a
// response and a collision. Tools that scan a line include it; so does client/change_address.hpp.
// Any frame restarts the watchdog of a drive whose controller has failed: its motors may run on.
//
//     for (std::uint8_t address = 1; address <= 247; ++address) {
//         const finding found = look_for(wire, address, {.response = milliseconds(50)});
//         if (found.what == presence::present) std::printf("node %d responds\n", address);
//     }
#pragma once

#include <array>
#include <cstdint>

#include <servobus/client/request_machine.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

enum class presence : std::uint8_t {
    no_response, ///< nothing came, or a gateway's exception: it got no response
    present,     ///< a valid response or an exception of the device
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
/// does not wait for a quarantine: the next request goes to another node, which ignores a late response. With
/// `gaps` it waits for them before each read.
template <class Line>
constexpr finding look_for(Line& on, std::uint8_t node_address, const response_limits& limits,
                           std::uint16_t address = 0, const bus_gaps& gaps = {}) {
    const modbus::frame<8> request = modbus::read_frame<typename Line::crc>(node_address, address, 1);
    std::array<std::uint8_t, 7> response{};
    typename Line::exchange x;
    request_machine call = request_machine::look();
    do {
        x = typename Line::exchange{request, response, on.timing(), limits};
        on.run(x, gaps);
    } while (call.looks_again(x.status(), x.has_received()));
    const status why = x.status();
    if (why.error() == errc::ok) return {presence::present, true, x.words()[0], {}};
    if (why.has_response()) return {presence::present, false, 0, why};
    if (why.error() == errc::no_echo) return {presence::failed, false, 0, why};
    if (request_machine::is_garbled(why, x.has_received())) return {presence::garbled, false, 0, why};
    // A gateway's exception says that the gateway got no response.
    const bool got_nothing = why.error() == errc::timeout || why.error() == errc::gateway_exception;
    return {got_nothing ? presence::no_response : presence::failed, false, 0, why};
}

} // namespace servobus
