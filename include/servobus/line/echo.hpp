// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many two-wire RS-485 adapters receive what they send. What a line needs to handle this local echo is a
// type of its own, so that a program pays for it only where it names it. line/line.hpp includes it.
//
//     constexpr posix::serial_settings settings{.keeps_echo = true};
//     if (serial.open("/dev/ttyUSB0", settings) != errc::ok) return 1;
//     line<posix::serial, counters, echoed> wire{serial, modbus::timing_at(settings.baud)};
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>

namespace servobus {

/// The adapter does not receive what it sends, or its port drops that before `sent()` turns true.
struct unechoed {};

/// The adapter receives what it sends, and its port keeps that: each request must come back, byte for byte,
/// before the response. A byte that differs is a collision; a missing echo means that the transceiver or its
/// wiring is not as configured.
class echoed {
  public:
    /// May be set between two transactions, for a tool that is configured at run time.
    bool is_on = true;

    constexpr void begin() {
        received_ = 0;
        differs_ = false;
    }

    /// Compares `arrived` with the request; the response may follow the echo in it. Returns how many bytes
    /// belong to the echo.
    constexpr std::size_t take(bytes request, bytes arrived) {
        std::size_t used = 0;
        for (; used < arrived.size() && !is_whole(request); ++used) {
            differs_ = differs_ || arrived[used] != request[received_];
            ++received_;
        }
        return used;
    }

    constexpr bool is_whole(bytes request) const { return received_ >= request.size(); }
    constexpr bool differs() const { return differs_; }

  private:
    std::uint16_t received_ = 0;
    bool differs_ = false;
};

template <class E> inline constexpr bool has_local_echo = false;
template <> inline constexpr bool has_local_echo<echoed> = true;

} // namespace servobus
