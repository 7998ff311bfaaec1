// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a line finds the end of a response whose length its request does not tell. It is a parameter of the line: most
// programs have only responses of known lengths, and pay nothing. The lines include it.
//
//     line<my_uart, counters, unechoed, modbus::open_lengths> wire{uart, modbus::timing_at(19200)};
//     constexpr auto by_third_byte = modbus::length_rule::counted(2); // it counts the rest
//     static_assert(by_third_byte.is_valid() && !modbus::length_rule::fixed(0).is_valid());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/modbus/growing_response.hpp>

namespace servobus::modbus {

/// Where the PDU of a response ends.
class length_rule {
  public:
    /// As the standard says for the function of the request: 0Ch, 11h, 18h and 2Bh grow, the others have one length. A
    /// function that the standard does not have ends after two bytes.
    static constexpr length_rule of_function() { return {kind::of_function, 0}; }
    /// After so many bytes, 1..253; 1 is the function alone.
    static constexpr length_rule fixed(std::uint8_t size) { return {kind::fixed, size}; }
    /// After as many bytes as the one at `place` says, 1..252, which counts from 0 at the function's code.
    static constexpr length_rule counted(std::uint8_t place) { return {kind::counted, place}; }
    /// Where a gap follows. A response that was cut is found by its CRC only.
    static constexpr length_rule until_gap() { return {kind::until_gap, 0}; }

    constexpr bool is_valid() const {
        if (kind_ == kind::fixed) return value_ >= 1 && value_ <= max_pdu;
        return kind_ != kind::counted || (value_ >= 1 && value_ < max_pdu);
    }
    constexpr bool ends_by_gap() const { return kind_ == kind::until_gap; }

  private:
    friend class open_lengths;
    enum class kind : std::uint8_t { of_function, fixed, counted, until_gap };
    constexpr length_rule(kind of, std::uint8_t value) : kind_{of}, value_{value} {}

    kind kind_;
    std::uint8_t value_;
};

/// For lines on which responses of any length come too.
class open_lengths {
  public:
    static constexpr bool are_open = true;

    constexpr open_lengths() = default; // of an exchange whose response has a known length
    /// `request` is the PDU of the request; only this call reads it.
    constexpr open_lengths(length_rule of, bytes request) : rule_{of}, growing_{request}, is_open_{true} {}

    constexpr bool is_open() const { return is_open_; }
    constexpr bool ends_by_gap() const { return is_open_ && rule_.ends_by_gap(); }
    /// The bytes of the longest response frame that the caller has room for.
    constexpr std::size_t room() const { return room_; }
    constexpr void set_room(std::size_t size) { room_ = static_cast<std::uint16_t>(size); }
    /// False if the response would be longer, which ends it.
    constexpr bool fits(std::size_t size) {
        is_too_long_ = size > room_;
        return !is_too_long_;
    }
    constexpr bool is_too_long() const { return is_too_long_; }
    /// The bytes that the PDU has at least, of which `begun` have come. They are as many as `begun` once it is whole.
    constexpr std::size_t least_length(bytes begun) {
        switch (rule_.kind_) {
        case length_rule::kind::of_function: return growing_.least_length(begun);
        case length_rule::kind::fixed: return rule_.value_;
        case length_rule::kind::counted: {
            const std::size_t head = std::size_t{rule_.value_} + 1;
            return begun.size() < head ? head : head + begun[head - 1];
        }
        case length_rule::kind::until_gap: return max_pdu;
        }
        return 2;
    }

  private:
    length_rule rule_ = length_rule::fixed(2);
    growing_response growing_{bytes{}};
    std::uint16_t room_ = 0;
    bool is_open_ = false;
    bool is_too_long_ = false;
};

} // namespace servobus::modbus
