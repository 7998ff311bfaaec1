// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port: the user's serial hardware and clock, as the library sees them. Whoever brings the library to new
// hardware writes one; a line is made on it.
//
//     struct uart { transfer send(bytes); bool sent(); transfer receive(byte_buffer); instant now(); };
//     static_assert(port<uart>);
//
//   request … crc |<- t3.5 ->|  (node works)  | response … crc |<- t3.5 ->|
//   ^send()        ^sent()                     ^receive()
//
// If you write a port:
// - `send(bytes)` takes as many bytes as it can now, perhaps none, and returns how many. It never waits. The line
//   offers the rest again. The bytes are copied or sent when it returns.
// - `sent()` is true once the last stop bit of everything that was taken has left the wire, not when the last
//   byte was queued. The port switches its RS-485 driver on in `send` and off before `sent` turns true, at the
//   latest t3.5 after the last stop bit. A port that cannot see the stop bit (a USB adapter) computes its time
//   from the number of bytes and the baud rate.
// - `receive(buffer)` moves what has arrived into the buffer, at most its size, and returns how many bytes; 0 if
//   nothing has. It never waits.
// - Bytes that arrived before the last stop bit left are no response. The line drops what it receives before
//   `sent()` is true. A port whose `send` blocks, or whose receiver may still hold an echo, empties its receiver
//   before `sent()` turns true. If that is asked so late that the response may have come, it keeps the bytes,
//   but not if the last request that it saw leave in time was echoed whole: then as many bytes as it has sent may be
//   the echo, which equals the response to a write. What follows them stays.
// - `now()` is a clock of microseconds that wraps at 2^32. A resolution of a millisecond is enough above 19200 Bd
//   in host timing if each node's `gaps.gap` is t3.5 and a millisecond: a gap that is measured by such a clock
//   may be a tick too short.
// - `wait(d)`, if there is one, may sleep up to `d`, and returns early when a byte arrives. Without it blocking
//   calls poll.
// - `expect(n)`, if there is one, tells a port that sleeps how many bytes of the response are missing, once it has
//   begun. The line calls it before it waits: a port that knows the baud rate can be awake when the last one comes.
// - `receive_failed` reports a garbled or lost character. While a response is awaited it ends the exchange;
//   before a request it counts as noise. Any other error ends the call that gets it. `port_lost` is for a port
//   that is gone: it reports that in each call from then on, and never blocks.
// - The line calls no member from an interrupt, and none is re-entered.
//
// - `endpoint`, `open(const endpoint&)`, `close()` and `is_open()`, if they are there, let `reconnecting.hpp` open the
//   port again after a loss.
// - `static constexpr bool has_gateway = true` is for a port that speaks Modbus TCP (mbap_port.hpp): a gateway may
//   respond in a node's place. A port that passes on to such a one repeats the constant.
//
// If you use the library: the line waits for the gaps and has every timeout; a port only moves bytes.
#pragma once

#include <concepts>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// How many bytes a port moved, or why it failed.
using transfer = result<std::uint16_t>;

/// A byte pipe with a clock; see the contract above.
template <class P>
concept port = requires(P& p, bytes out, byte_buffer in) {
    { p.send(out) } -> std::same_as<transfer>;
    { p.sent() } -> std::same_as<bool>;
    { p.receive(in) } -> std::same_as<transfer>;
    { p.now() } -> std::same_as<instant>;
};

/// A port that can sleep until a byte comes.
template <class P>
concept waiting_port = port<P> && requires(P& p, duration d) {
    p.wait(d);
};

/// A port that is told how many bytes of a response are missing.
template <class P>
concept expecting_port = waiting_port<P> && requires(P& p, std::uint16_t missing) {
    p.expect(missing);
};

/// True for a port of Modbus TCP: exceptions 0Ah and 0Bh, and each exception to a broadcast, are its gateway's.
template <class P> inline constexpr bool has_gateway = false;
template <class P>
requires requires { P::has_gateway; }
inline constexpr bool has_gateway<P> = P::has_gateway;

} // namespace servobus
