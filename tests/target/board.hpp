// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The code that a user of a small core writes: four functions for the UART and a clock. board.cpp
// implements them, with a simulated ZLAC8015D at the other end of the line. The figures of tests/target are
// given without and with them.
#pragma once

#include <cstdint>

#include <servobus/line/port.hpp>

extern "C" {
/// Sends all bytes and returns their number.
std::uint32_t uart_send(const std::uint8_t* data, std::uint32_t size);
bool uart_sent();
/// The next byte, or -1.
std::int32_t uart_receive();
std::uint32_t clock_us();

/// The measured part of each program. True if it was completed.
bool job();
}

/// The port over the four functions.
struct uart {
    servobus::transfer send(servobus::bytes all) {
        return static_cast<std::uint16_t>(uart_send(all.data(), all.size()));
    }
    bool sent() { return uart_sent(); }
    servobus::transfer receive(servobus::byte_buffer into) {
        const std::int32_t byte = uart_receive();
        if (byte < 0) return std::uint16_t{0};
        into[0] = static_cast<std::uint8_t>(byte);
        return std::uint16_t{1};
    }
    servobus::instant now() { return {clock_us()}; }
};
