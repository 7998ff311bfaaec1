// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A TCP connection to one of the addresses of a host, the part that no system call is in. posix/tcp.hpp and
// windows/tcp.hpp include it; a port over lwIP can use it too, with its own `addrinfo`.
//
//     const tcp_settings wanted{.connect_within = milliseconds(2000)};
//     const errc why = connect_to_first(found, wanted.connect_within, clock_now, connect_to);
//     if (why != errc::ok) return 1;
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

struct tcp_settings {
    /// Bits a second of the gateway's wire: `sent()` waits for the time of the bytes there. A rate below
    /// the true one makes the line drop responses as too early. 0: not known; what the system has taken is sent.
    std::uint32_t baud = 0;
    duration connect_within = milliseconds(3000); ///< for all addresses of the host together
};

/// The time that is left at `now` until `end`; zero if that has passed.
constexpr duration time_left(instant now, instant end) {
    return went_back(end, now) ? since(now, end) : duration{};
}

/// Calls `connect_to(address, within)` for each of a list of addresses, as getaddrinfo returns it, until one returns
/// `ok`. Each gets its share of the time that is left: the first may be of a network that this host cannot reach.
/// Errors: that of the last address.
template <class Address, class Clock, class Connect>
constexpr errc connect_to_first(const Address* addresses, duration within, Clock now, Connect connect_to) {
    std::uint32_t left = 0;
    for (const Address* a = addresses; a != nullptr; a = a->ai_next) ++left;
    const instant end = now() + within;
    errc why = errc::port_lost;
    for (const Address* a = addresses; a != nullptr && why != errc::ok; a = a->ai_next, --left)
        why = connect_to(*a, duration{time_left(now(), end).us / left});
    return why;
}

} // namespace servobus
