// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Changes a node's baud rate over the bus. Whether a drive acknowledges at the old rate or at the new one
// is rarely stated, and some use the new one only after their next start. So the function checks at which
// rate the drive responds afterwards. Set-up tools include it.
//
//     const auto reopen = [](std::uint32_t baud) {
//         return serial.open("/dev/ttyUSB0", {.baud = baud, .format = c630s::device::facts.format});
//     };
//     using enum c630s::baud_rate;
//     const status w = change_baud_rate<c630s::rs485_baud_rate>(servo, baud_9600, {57600, 9600}, reopen);
#pragma once

#include <array>
#include <cstdint>

#include <servobus/client/change_address.hpp>

namespace servobus {

/// The rates of a change, in bits a second.
struct baud_change {
    std::uint32_t from;
    std::uint32_t to;
};

/// Writes `code`, the device's number for `rates.to`, into the register `R` of the client's node, and checks
/// at which rate the drive responds afterwards. `set_port(baud)` sets the port and returns a `status`; the
/// line's timing follows. Port and line stay at the new rate if the drive responds there, else at the old one;
/// other drives on the line keep their rate. Blocking. It takes a read, unless an echo is ruled out, one write
/// and three looks (`look_for`). Errors: the write's own and the port's; `not_reached`: the drive responds at
/// the old rate only, and takes the new one at its next start or not at all; `timeout`: it responds at
/// neither.
template <const auto& R, class Line, class Device, class SetPort>
constexpr status change_baud_rate(client<Line, Device>& of, register_value<R> code, baud_change rates,
                                  SetPort&& set_port) {
    auto& line = of.line();
    const auto go_to = [&](std::uint32_t baud) {
        const status why = set_port(baud);
        if (!why) return why;
        return line.retime(modbus::timing_at(baud, line.timing().mode, line.timing().inter_byte));
    };

    const status done = detail::write_line_setting<R>(of, code);
    if (done.outcome() == outcome::not_sent || done.outcome() == outcome::refused) return done;
    // Twice at the new one: the drive may change slowly.
    for (const std::uint32_t baud : std::array<std::uint32_t, 3>{rates.to, rates.from, rates.to}) {
        if (const status why = go_to(baud); !why) return status::sent(why.error());
        if (look_for(line, of.node().address, of.node().limits, R.address).what != presence::present)
            continue;
        return status::sent(baud == rates.from ? errc::not_reached : errc::ok);
    }
    const status why = go_to(rates.from);
    return status::sent(why ? errc::timeout : why.error());
}

} // namespace servobus
