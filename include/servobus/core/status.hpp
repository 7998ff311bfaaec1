// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a call ended: the error codes of the library, and the status that every call returns which sends a
// request or refuses to. The headers that declare such calls include this one.
//
//     constexpr status cut = status::sent(errc::timeout);
//     static_assert(!cut && cut.error() == errc::timeout && cut.outcome() == outcome::unknown);
//     constexpr status refused{errc::out_of_range};
//     static_assert(refused.outcome() == outcome::not_sent && status{}.outcome() == outcome::done);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus {

/// Every error of the library. An error of the first group means that its request was not sent; a command
/// of several requests may have sent earlier ones, which its outcome tells. promises.md lists the errors with
/// the promises that they belong to.
enum class errc : std::uint8_t {
    ok,
    // refused by the library before this request was sent
    out_of_range, ///< a value is outside its register's range
    inexact,      ///< a quantity is not a whole number of the register's counts
    bad_argument, ///< an address, index, quantity or size that the protocol or the device does not allow
    needs_init,   ///< the cached drive state is invalid: initialise the drive; a void `ram_only`: get another
    needs_word_order, ///< the word order of 32-bit values is not known
    needs_homing,     ///< the position of the axis is not known: home it, or declare its position
    wrong_state,      ///< the drive is not in the state or mode that this command requires
    busy,             ///< another exchange or routine is in progress, or the axis is still moving
    faulted,          ///< the drive reports a fault
    not_in_plan,      ///< the line's bus has a plan without such a request: see `own_requests(..)` of a plan
    line_busy,        ///< no gap on the line was long enough to send
    // the transport
    send_failed,    ///< the port accepted no byte of the request
    partial_send,   ///< the port failed after it had accepted part of the request
    receive_failed, ///< the port failed while receiving
    port_lost,      ///< the port no longer exists (unplugged, closed), or the network has no way to it
    clock_stopped,  ///< the port's clock does not advance
    // the local echo of an adapter that receives what it sends
    no_echo,   ///< the echo did not arrive within the time that sending takes
    collision, ///< the echo differs from the request: another device transmitted
    own_echo,  ///< what arrived may be the request's own echo: no response has ruled that out yet
    // the response
    timeout,            ///< no response began within the time limit
    gateway_exception,  ///< no response of the device: a gateway responded in its place (0Ah, 0Bh)
    truncated_response, ///< the response ended before its last byte
    bad_crc,            ///< the response's CRC is wrong
    wrong_node,         ///< the frame comes from another address
    wrong_function,     ///< the function code differs from the request's
    wrong_byte_count,   ///< a read response has another length than requested
    wrong_address,      ///< a write was acknowledged with another register address
    wrong_value,        ///< a single write was acknowledged with another value
    wrong_quantity,     ///< a multiple write was acknowledged with another number of registers
    too_short,          ///< the frame is shorter than frames of its function
    too_long,           ///< the frame is longer than frames of its function
    bad_gap,            ///< strict timing: a gap inside the frame exceeded t1.5
    exception,          ///< the device responded with an exception; `status::exception()` has its number
    acknowledged,       ///< exception 5: accepted, and still being carried out (outcome: unknown)
    // from routines, and from calls that check what they read
    unexpected_value, ///< a register does not read back as written, or holds an unusable value
    not_executed,     ///< sent, but the drive's state shows that it was not executed (outcome: unknown)
    not_reached,      ///< a state was not reached within its time limit
    stopped_short,    ///< a move ended before its target: an input, a fault or another stop cut it
    preempted,        ///< a stop pre-empted the routine
    command_timeout,  ///< the program commanded nothing for its command timeout: the drive was stopped
    already_assigned, ///< another terminal already has this function; nothing was written
    // opening a port
    rs485_refused, ///< the system or the port's driver cannot switch an RS-485 driver as asked
    rs485_late,    ///< the RS-485 driver would be switched off later than t3.5 after the last stop bit
    port_in_use,   ///< another program has the port; on Windows perhaps this user may not open it
    no_permission, ///< this user may not open the port
    no_such_port,  ///< no port has this name: the name is wrong, or the adapter is unplugged
};

/// A short English description of the error.
constexpr const char* text(errc e) {
    switch (e) {
    case errc::ok: return "ok";
    case errc::out_of_range: return "value outside the register's range";
    case errc::inexact: return "value is no whole number of the register's counts";
    case errc::bad_argument: return "an argument that is not possible";
    case errc::needs_init: return "the drive must be initialised first";
    case errc::needs_word_order: return "the word order is not known";
    case errc::needs_homing: return "the axis must be homed first";
    case errc::wrong_state: return "the drive is not in the state this command needs";
    case errc::busy: return "busy";
    case errc::faulted: return "the drive reports a fault";
    case errc::not_in_plan: return "the plan of the line's bus has no such request";
    case errc::line_busy: return "the line was not quiet long enough to send";
    case errc::send_failed: return "the request could not be sent";
    case errc::partial_send: return "the port failed while sending";
    case errc::receive_failed: return "the port failed while receiving";
    case errc::port_lost: return "the port is gone";
    case errc::clock_stopped: return "the clock does not advance";
    case errc::rs485_refused: return "the port cannot switch an RS-485 driver so";
    case errc::rs485_late: return "the RS-485 driver would be switched off later than t3.5";
    case errc::port_in_use: return "another program has the port";
    case errc::no_permission: return "no permission for the port";
    case errc::no_such_port: return "there is no such port";
    case errc::no_echo: return "the request did not come back as echo";
    case errc::collision: return "collision: the echo differs from the request";
    case errc::own_echo: return "what came may be the request's own echo";
    case errc::timeout: return "no response";
    case errc::gateway_exception: return "no response of the device, says its gateway";
    case errc::truncated_response: return "the response stopped half-way";
    case errc::bad_crc: return "wrong CRC";
    case errc::wrong_node: return "frame of another node";
    case errc::wrong_function: return "another function code than the request's";
    case errc::wrong_byte_count: return "wrong byte count";
    case errc::wrong_address: return "acknowledged at another address";
    case errc::wrong_value: return "acknowledged with another value";
    case errc::wrong_quantity: return "acknowledged with another number of registers";
    case errc::too_short: return "frame too short";
    case errc::too_long: return "frame too long";
    case errc::bad_gap: return "gap inside the frame";
    case errc::exception: return "exception";
    case errc::acknowledged: return "accepted, but not finished yet";
    case errc::unexpected_value: return "a register holds another value than expected";
    case errc::not_executed: return "sent, but not carried out";
    case errc::preempted: return "a stop took its place";
    case errc::command_timeout: return "the command timeout stopped the drive";
    case errc::not_reached: return "the expected state was not reached in time";
    case errc::stopped_short: return "the move ended before its target";
    case errc::already_assigned: return "another terminal has this function";
    }
    return "unknown error";
}

/// The four ways in which a write can end. `unknown` is reported to the caller; the library repeats
/// stops only.
enum class outcome : std::uint8_t {
    done,     ///< acknowledged by exactly one valid response, or a broadcast that was sent completely
    refused,  ///< the device responded with an exception: not executed
    not_sent, ///< refused by the library or the port before a byte was sent: not executed
    unknown,  ///< sent without a valid response, or a later step of the command failed: executed or not
};

constexpr const char* text(outcome o) {
    switch (o) {
    case outcome::done: return "done";
    case outcome::refused: return "refused";
    case outcome::not_sent: return "not sent";
    case outcome::unknown: return "unknown";
    }
    return "unknown";
}

/// The end of a call: the error, the exception number of the response, and whether anything was sent. Its four bytes
/// fill a word, so that a small core returns it in one register.
class [[nodiscard]] alignas(4) status {
  public:
    /// Done.
    constexpr status() = default;
    /// Nothing was sent.
    constexpr status(errc why) : code_{why} {} // NOLINT: implicit, `return errc::bad_argument;`
    /// Some or all of the request may have been on the line. `exception`: the number in the response.
    static constexpr status sent(errc why, std::uint8_t exception = 0) { return {why, exception, true}; }

    constexpr explicit operator bool() const { return code_ == errc::ok; }
    constexpr errc error() const { return code_; }
    /// The raw exception number (0..255) of `errc::exception`, `gateway_exception` and `acknowledged`; else 0.
    /// Devices define their own numbers; `profile::meaning` gives the text.
    constexpr std::uint8_t exception() const { return exception_; }
    /// True if any byte of the request may have been on the line.
    constexpr bool was_sent() const { return was_sent_ != 0; }
    /// True if the device responded, either as requested or with an exception of its own.
    constexpr bool has_response() const {
        return code_ == errc::ok || code_ == errc::exception || code_ == errc::acknowledged;
    }
    constexpr servobus::outcome outcome() const {
        if (code_ == errc::ok) return servobus::outcome::done;
        if (code_ == errc::exception) return servobus::outcome::refused;
        return was_sent() ? servobus::outcome::unknown : servobus::outcome::not_sent;
    }

    /// The same for a call of several requests: `sent` says whether one of them changes the device.
    constexpr status with_sent(bool sent) const { return {code_, exception_, sent}; }
    constexpr void mark_sent() { was_sent_ = 1; }
    /// Replaces the error code; the rest is kept.
    constexpr void end(errc why) { code_ = why; }
    constexpr void set_exception(std::uint8_t number) { exception_ = number; }

    friend constexpr bool operator==(const status&, const status&) = default;
    /// Compares the error alone.
    friend constexpr bool operator==(const status& s, errc why) { return s.code_ == why; }

  private:
    constexpr status(errc why, std::uint8_t exception, bool was_sent)
        : code_{why}, exception_{exception}, was_sent_{was_sent} {}

    errc code_ = errc::ok;
    std::uint8_t exception_ = 0;
    std::uint16_t was_sent_ = 0; // a bool in two bytes: without padding all four bytes are copied as a word
};

static_assert(sizeof(status) == 4);

} // namespace servobus
