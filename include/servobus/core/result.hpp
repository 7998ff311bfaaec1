// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What can go wrong, and how it is handed to the caller: errors as values, four bytes for a 16-bit reading.
#pragma once

#include <cstdint>

namespace servobus {

/// Every error of the library. The first group means that nothing was sent. Which promise each keeps is in
/// promises.md.
enum class errc : std::uint8_t {
    ok,
    // refused here, before anything was sent
    out_of_range, ///< a value outside its register's range
    inexact,      ///< a quantity that is no whole number of the register's counts
    bad_argument, ///< a unit address, index, quantity or size that the protocol or the device does not have
    needs_init,   ///< what was known of the drive is void: initialise it first
    needs_word_order, ///< the order of the words of 32-bit values is not known yet
    needs_homing,     ///< where the axis is, is not known: home it, or declare its position
    wrong_state,      ///< the drive is not in the state or mode that this command needs
    busy,             ///< another exchange or routine is under way, or the axis still moves
    faulted,          ///< the drive reports a fault
    line_busy,        ///< the line never became silent long enough to send
    // the transport
    send_failed,    ///< the port took no byte of the request
    partial_send,   ///< the port failed while the request was leaving
    receive_failed, ///< the port failed while the response was awaited
    port_lost,      ///< the port is gone (unplugged, closed)
    clock_stopped,  ///< the port's clock stands still
    // the echo of an adapter that hears itself
    no_echo,   ///< it did not come back in the request's own time
    collision, ///< it came back changed: somebody else was talking
    own_echo,  ///< what came may be the request itself: no device has answered yet
    // the response
    timeout,            ///< no response began in time
    truncated_response, ///< the response stopped half-way
    bad_crc,            ///< the response's CRC is wrong
    wrong_unit,         ///< the frame comes from another unit
    wrong_function,     ///< another function code than the request's
    wrong_byte_count,   ///< a read response of another length than was asked for
    wrong_address,      ///< a write was acknowledged at another address
    wrong_value,        ///< a single write was acknowledged with another value
    wrong_quantity,     ///< a multiple write was acknowledged with another number of registers
    too_short,          ///< fewer bytes than a frame of this function has
    too_long,           ///< more bytes than a frame of this function has
    bad_gap,            ///< strict timing: a gap inside the frame was longer than t1.5
    exception,          ///< the device answered with an exception; its raw number is beside
    // a routine's own
    unexpected_value, ///< a register did not read back as written, or holds what the routine cannot accept
    not_executed,     ///< acknowledged, and the drive's state shows that it was not carried out
    not_reached,      ///< a state was not reached within its time
    preempted,        ///< a stop took the routine's place
    already_assigned, ///< another terminal has this function; nothing was written
};

/// The error's meaning in a few words of English.
constexpr const char* text(errc e) {
    switch (e) {
    case errc::ok: return "ok";
    case errc::out_of_range: return "value outside the register's range";
    case errc::inexact: return "value is no whole number of the register's counts";
    case errc::bad_argument: return "address, index or size that the device does not have";
    case errc::needs_init: return "the drive must be initialised first";
    case errc::needs_word_order: return "the word order is not known";
    case errc::needs_homing: return "the axis must be homed first";
    case errc::wrong_state: return "the drive is not in the state this command needs";
    case errc::busy: return "busy";
    case errc::faulted: return "the drive reports a fault";
    case errc::line_busy: return "the line never became silent";
    case errc::send_failed: return "the request could not be sent";
    case errc::partial_send: return "the port failed while sending";
    case errc::receive_failed: return "the port failed while receiving";
    case errc::port_lost: return "the port is gone";
    case errc::clock_stopped: return "the clock stands still";
    case errc::no_echo: return "the request did not come back as echo";
    case errc::collision: return "collision: the echo differs from the request";
    case errc::own_echo: return "what came may be the request's own echo";
    case errc::timeout: return "no answer";
    case errc::truncated_response: return "the answer stopped half-way";
    case errc::bad_crc: return "wrong CRC";
    case errc::wrong_unit: return "frame of another unit";
    case errc::wrong_function: return "another function code than the request's";
    case errc::wrong_byte_count: return "wrong byte count";
    case errc::wrong_address: return "acknowledged at another address";
    case errc::wrong_value: return "acknowledged with another value";
    case errc::wrong_quantity: return "acknowledged with another number of registers";
    case errc::too_short: return "frame too short";
    case errc::too_long: return "frame too long";
    case errc::bad_gap: return "gap inside the frame";
    case errc::exception: return "exception";
    case errc::unexpected_value: return "a register holds another value than expected";
    case errc::not_executed: return "acknowledged, but not carried out";
    case errc::preempted: return "a stop took its place";
    case errc::not_reached: return "the expected state was not reached in time";
    case errc::already_assigned: return "another terminal has this function";
    }
    return "unknown error";
}

/// An error with the exception number that came with it: 0 unless `code == errc::exception`. The number is
/// the device's own; `profile::meaning` has its words.
struct failure {
    errc code = errc::ok;
    std::uint8_t exception = 0;

    friend constexpr bool operator==(failure, failure) = default;
};

/// True if the device has answered: with what it was asked for, or with an exception.
constexpr bool is_answered(const failure& why) { return why.code == errc::ok || why.code == errc::exception; }

/// A value or the reason why there is none.
template <class T> class [[nodiscard]] result {
  public:
    constexpr result(T value) : value_{value} {} // NOLINT: implicit, `return value;`
    constexpr result(failure f) : error_{f} {}   // NOLINT: implicit, `return failure{...};`

    constexpr explicit operator bool() const { return error_.code == errc::ok; }
    /// The value; a default-made one if there is an error, so look first.
    constexpr const T& value() const { return value_; }
    constexpr const T& operator*() const { return value_; }
    constexpr const T* operator->() const { return &value_; }
    constexpr T* operator->() { return &value_; }
    /// It becomes an error; the value stays what it is.
    constexpr void fail(failure why) { error_ = why; }
    constexpr T value_or(T other) const { return *this ? value_ : other; }

    constexpr errc error() const { return error_.code; }
    /// The raw exception number (0..255), 0 if the error is no exception.
    constexpr std::uint8_t exception() const { return error_.exception; }
    constexpr failure why() const { return error_; }

  private:
    T value_{};
    failure error_{};
};

static_assert(sizeof(result<std::int16_t>) == 4);

/// The four ways a write can end. Nothing is written twice by itself: `unknown` goes to the caller.
enum class outcome : std::uint8_t {
    done,     ///< acknowledged by exactly one valid response (or broadcast in full)
    refused,  ///< the device answered with an exception: not done
    not_sent, ///< refused here or by the port before a byte left: not done
    unknown,  ///< sent, but no valid answer: done or not
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

/// How a write ended, and why. Four bytes that fill a word: a small core hands them on in one register.
class [[nodiscard]] alignas(4) written {
  public:
    constexpr written() = default;
    /// `sent`: whether any byte of the request may have been on the line.
    constexpr written(failure f, bool sent) : error_{f}, was_sent_{sent} {}

    static constexpr written not_sent(errc why) { return {failure{why, 0}, false}; }

    constexpr explicit operator bool() const { return error_.code == errc::ok; }
    constexpr servobus::outcome outcome() const {
        if (error_.code == errc::ok) return servobus::outcome::done;
        if (error_.code == errc::exception) return servobus::outcome::refused;
        return was_sent() ? servobus::outcome::unknown : servobus::outcome::not_sent;
    }
    constexpr errc error() const { return error_.code; }
    constexpr std::uint8_t exception() const { return error_.exception; }
    constexpr failure why() const { return error_; }
    constexpr bool was_sent() const { return was_sent_ != 0; }
    /// It ends in another way; whether it was sent stays what it is.
    constexpr void end(errc why) { error_.code = why; }
    constexpr void set_exception(std::uint8_t number) { error_.exception = number; }

  private:
    failure error_{};
    std::uint16_t was_sent_ = 0; // a truth in two bytes: none is padding, so that all four go at once
};

static_assert(sizeof(written) == 4);

} // namespace servobus
