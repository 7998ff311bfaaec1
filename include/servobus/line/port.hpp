// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a user's hardware is to the library: a byte pipe and a clock. The contract speaks to two readers.
//
//   request … crc |<- t3.5 ->|  (node works)  | response … crc |<- t3.5 ->|
//   ^send()        ^sent()                     ^receive()
//
// If you write a port:
// - `send(bytes)` takes as many bytes as it can now, at least none, and returns how many; it never waits. The
//   caller offers the rest again. The bytes are copied or gone when it returns.
// - `sent()` is true once the last stop bit of all that was taken has left the wire, not when the last byte
//   was queued. The port switches its RS-485 driver on in `send` and off again before `sent` turns true, at
//   the latest t3.5 after the last stop bit. A port that cannot see the stop bit (an adapter behind USB)
//   reckons it from the byte count and the baud rate.
// - `receive(buffer)` moves what has arrived into the buffer, at most its size, and returns how many bytes; 0
//   means nothing yet. It never waits.
// - What arrived before the last stop bit left is no response. The line drops what it receives before
// `sent()`
//   is true; a port whose `send` blocks, or whose receiver may still hold an echo, empties the receiver
//   before `sent()` turns true.
// - `now()` is a clock of microseconds that counts on through its wrap at 2^32; a resolution of a millisecond
//   will do above 19200 Bd in host timing, if each node's `quiet.gap` is t3.5 and a millisecond: a silence
//   that is measured so may be a tick too short.
// - `wait(d)`, if there is one, may sleep up to `d` and returns early when a byte comes. Without it the
//   blocking calls poll.
// - `receive_failed` is a character that came garbled or was lost; while a response is awaited it ends the
// call,
//   before a request it is rubbish like any other. Any other error ends the call that meets it. A port that
//   is gone stays gone and says so each time: it never blocks.
// - Nothing is called from an interrupt, and nothing is re-entered.
//
// If you use the library: the line waits for the silences and owns every timeout; a port only moves bytes.
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

} // namespace servobus
