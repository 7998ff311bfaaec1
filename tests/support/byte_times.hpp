// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A UART in virtual time for a server of rows: bytes arrive at times, and the server is stepped between them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>

namespace byte_times {

using byte_list = std::vector<std::uint8_t>;

/// Each call of `receive` returns what has arrived by then, at most `burst` bytes.
struct uart {
    servobus::instant time{};
    std::deque<std::uint8_t> arrived;
    byte_list sent_bytes;
    std::size_t burst = 1;
    std::size_t takes = 1000; ///< bytes that a call of `send` takes
    std::size_t asked = 0;    ///< the size of the last buffer
    std::size_t taken = 0;    ///< bytes that `receive` has returned
    bool is_garbled = false;
    bool has_left = true;
    bool fails = false;

    servobus::transfer send(servobus::bytes all) {
        if (fails) return servobus::errc::port_lost;
        const std::size_t n = std::min(all.size(), takes);
        sent_bytes.insert(sent_bytes.end(), all.begin(), all.begin() + n);
        return static_cast<std::uint16_t>(n);
    }
    bool sent() { return has_left; }
    servobus::transfer receive(servobus::byte_buffer into) {
        asked = into.size();
        if (is_garbled) {
            is_garbled = false;
            return servobus::errc::receive_failed;
        }
        const std::size_t n = std::min({into.size(), burst, arrived.size()});
        for (std::size_t i = 0; i < n; ++i) {
            into[i] = arrived.front();
            arrived.pop_front();
        }
        taken += n;
        return static_cast<std::uint16_t>(n);
    }
    servobus::instant now() { return time; }
};

/// Completes a frame by its CRC, bit by bit.
inline byte_list framed(byte_list body) {
    unsigned crc = 0xFFFF;
    for (const std::uint8_t byte : body) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xA001u : 0u);
    }
    body.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
    body.push_back(static_cast<std::uint8_t>(crc >> 8));
    return body;
}

} // namespace byte_times
