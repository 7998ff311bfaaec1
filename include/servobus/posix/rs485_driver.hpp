// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, POSIX: how the kernel switches the RS-485 driver of a serial port. A board states this in its device tree; a
// program states it where the board does not.
//
//     servobus::posix::serial_settings wanted{.baud = 9600, .rs485 = true};
//     wanted.driver = {.polarity = servobus::posix::rs485_polarity::rts_after_send,
//                      .before_send = servobus::milliseconds(1)};
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>

namespace servobus::posix {

/// When RTS is asserted.
enum class rs485_polarity : std::uint8_t {
    as_configured,  ///< as the kernel has it; `rts_on_send` if it has neither
    rts_on_send,    ///< while the port sends (SER_RS485_RTS_ON_SEND)
    rts_after_send, ///< while it does not send: the driver is active low (SER_RS485_RTS_AFTER_SEND)
};

/// The driver of a port that is opened with `serial_settings::rs485`. By default all stays as the device tree, or a
/// program before, has configured it in the kernel (TIOCGRS485 of Linux).
struct rs485_driver {
    /// The delay that the kernel has.
    static constexpr duration as_configured{0xFFFF'FFFFu};

    rs485_polarity polarity = rs485_polarity::as_configured;
    /// From the driver's switching on to the first bit. The kernel counts whole ms: a part of one is rounded up.
    duration before_send = as_configured;
    /// From the last stop bit to the driver's switching off, at most t3.5 of the line; in whole ms likewise.
    duration after_send = as_configured;
};

namespace detail {

/// How the kernel took an `rs485_driver`.
struct driver_result {
    errc why = errc::ok;
    int error = 0;          ///< errno; 0 if no call has failed
    duration before_send{}; ///< the delay that the kernel has now
};

} // namespace detail

} // namespace servobus::posix
