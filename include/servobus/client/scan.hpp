// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Who is on a line: one harmless read to an address tells silence, a response and a collision apart. Any
// frame feeds the watchdog of a drive whose controller is dead: its motors may run on.
#pragma once

#include <array>
#include <cstdint>

#include <servobus/line/line.hpp>

namespace servobus {

enum class presence : std::uint8_t {
    silent,  ///< nothing came
    present, ///< a valid response, an exception too
    garbled, ///< bytes came that are no response, each time: two devices at one address, or another baud rate
    failed,  ///< the port or its line is no good
};

/// What came from an address. `word` is what `address` holds, if `has_word`.
struct finding {
    presence what = presence::silent;
    bool has_word = false;
    std::uint16_t word = 0;
    failure why{};
};

/// Asks `unit` for the register at `address`, once more if what comes is no response. Blocking; bounded by
/// twice `line::bound` for a read of one register. After no response it waits for no quarantine: the next
/// request goes to another unit, for which a late response is another unit's frame.
template <class Line>
constexpr finding look_for(Line& on, std::uint8_t unit, const response_limits& limits,
                           std::uint16_t address = 0) {
    const modbus::frame<8> request = modbus::read_frame<typename Line::crc>(unit, address, 1);
    finding found;
    for (int attempt = 0; attempt < 2; ++attempt) {
        std::array<std::uint8_t, 7> response{};
        modbus::exchange x{request, response, on.timing(), limits};
        on.run(x, {});
        found.why = x.why();
        if (x.why().code == errc::ok) return {presence::present, true, x.words()[0], {}};
        if (x.why().code == errc::exception) return {presence::present, false, 0, x.why()};
        // A garbled character is what two devices, or another baud rate, look like to a UART.
        if (x.why().code < errc::no_echo && x.why().code != errc::receive_failed)
            return {presence::failed, false, 0, x.why()};
        // A foreign byte or a deaf wait ends as a time-out too: what came in the meantime tells.
        if (x.why().code == errc::timeout && !x.has_heard()) return found;
    }
    found.what = found.why.code == errc::no_echo ? presence::failed : presence::garbled;
    return found;
}

} // namespace servobus
