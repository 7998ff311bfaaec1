// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// For who writes a port whose system does not report the last stop bit: when the bytes that it was given have left
// the wire, computed from their number and the baud rate.
//
//     servobus::transmission sending{115200};
//     sending.add(8, servobus::instant{1000}); // 8 bytes given to the system at 1000 us
//     return sending.is_over(servobus::instant{1695});
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/time.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus {

/// The bytes that are on their way. A default-constructed one knows no rate: there each byte has left at once.
class transmission {
  public:
    constexpr transmission() = default;
    /// `baud` in bits a second; `bits` of a character with start, parity and stop bits: 10 (8N1) or 11.
    constexpr explicit transmission(std::uint32_t baud, unsigned bits = 10) : baud_{baud}, bits_{bits} {}

    /// Adds bytes that the system was given at `at`: the time *before* the call that gave them. After it, a thread
    /// that was delayed inside the call would take a response for an echo.
    constexpr void add(std::size_t count, instant at) {
        const instant start = is_under_way_ && !is_over(at) ? end_ : at;
        end_ = start + duration{baud_ != 0 ? microseconds_of(count) : 0u};
        unechoed_ += static_cast<std::int32_t>(count);
        is_under_way_ = true;
    }
    /// False before the first byte and after `finish`.
    constexpr bool is_under_way() const { return is_under_way_; }
    /// The last stop bit has left, by the time.
    constexpr bool is_over(instant at) const { return !went_back(end_, at); }
    /// Later than t3.5 after the last stop bit: what arrives may be the response.
    constexpr bool may_be_answered(instant at) const {
        return is_over(at) && !(since(end_, at) < duration{modbus::timing_at(baud_).t3_5});
    }
    /// The port has reported these bytes as sent.
    constexpr void finish() {
        is_under_way_ = false;
        unechoed_ = 0;
    }
    /// For another rate: what was under way is forgotten, but not whether the adapter echoes.
    constexpr void restart(std::uint32_t baud, unsigned bits = 10) {
        baud_ = baud;
        bits_ = bits;
        finish();
    }

    // For a port that discards the local echo of its adapter. Each `at` is read after the bytes, so that no delay of
    // the thread makes a response look like an echo.

    /// `count` bytes have arrived by `at`. They are an echo as long as no response can have come.
    constexpr void note_arrival(std::size_t count, instant at) {
        if (is_under_way_ && !may_be_answered(at)) unechoed_ -= static_cast<std::int32_t>(count);
    }
    /// So many of the bytes that have arrived by `at` are to be discarded: all while no response can have come. After
    /// that, of an adapter that echoes, those that are missing of the echo: it equals the response to a write, and what
    /// follows it is no echo.
    constexpr std::size_t most_to_discard(instant at) const {
        if (!may_be_answered(at)) return ~std::size_t{0};
        return has_echoed_ && unechoed_ > 0 ? static_cast<std::size_t>(unechoed_) : 0;
    }
    /// `count` of them were discarded.
    constexpr void note_discarded(std::size_t count) { unechoed_ -= static_cast<std::int32_t>(count); }
    /// Before `finish`: the adapter echoes if all of these bytes have come back before a response can have come. If
    /// they have not, and it is asked after that, it stays as it was.
    constexpr void decide_echo(instant at) {
        if (unechoed_ <= 0 || !may_be_answered(at)) has_echoed_ = unechoed_ <= 0;
    }

  private:
    constexpr std::uint32_t microseconds_of(std::size_t count) const {
        return static_cast<std::uint32_t>((std::uint64_t{count} * bits_ * 1'000'000u + baud_ - 1) / baud_);
    }

    instant end_{};
    std::uint32_t baud_ = 0;
    unsigned bits_ = 10;
    std::int32_t unechoed_ = 0; // bytes under way whose echo has not arrived
    bool is_under_way_ = false;
    bool has_echoed_ = false;
};

} // namespace servobus
