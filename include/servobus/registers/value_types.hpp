// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The types of values that are no integers of one or two registers. A type states how words become a value; `with`
// adds what the other columns of the manual's table state. any_value.hpp includes it; maps of drives do not.
//
//     inline constexpr input_reg<f32, meter> power{0x000C, full<f32>, units::watt, no_default};
//     inline constexpr input_reg<with<u16, bits<0, 3>>, meter> mode{0x0010, full<u16>, no_unit, no_default};
//     inline constexpr ro<i16> exponent{40084, full<i16>, no_unit, no_default};
//     using scaled = with<i16, or_none<-0x8000>, ten_to<exponent>>;
//     inline constexpr ro<scaled> ac_power{40083, full<i16>, units::watt, no_default};
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/registers/wire.hpp>

namespace servobus {

using u64 = std::uint64_t; ///< of four registers
using i64 = std::int64_t;  ///< of four registers
using f32 = float;         ///< IEEE 754 of two registers
using f64 = double;        ///< IEEE 754 of four registers

/// Decimal digits, four in a register: 0x1234 is 1234. A digit above 9 is no value, so a reading is a `maybe`.
template <std::size_t Words> struct bcd {
    static_assert(Words == 1 || Words == 2, "bcd<1> has four digits, bcd<2> has eight");
};
/// The top bit is the sign, the other bits are the magnitude: 0x8003 is -3.
template <std::size_t Words> struct sign_magnitude {
    static_assert(Words == 1 || Words == 2, "sign_magnitude<1> has 16 bits, sign_magnitude<2> has 32");
};
template <std::size_t Words> class text_of; // registers/text_value.hpp

/// A `T` with options in any order. Each option is one column of a map.
template <class T, class... Options> struct with {};

/// Bits `First` to `Last` of one register, counted from 0 at the lowest. A signed type has its sign in bit `Last`.
template <unsigned First, unsigned Last> struct bits {};
using high_byte = bits<8, 15>;
using low_byte = bits<0, 7>;
/// A number of counts that is added before the scale: `offset<-1000>` makes 1250 of the device 250.
template <std::int32_t Counts> struct offset {};
/// Raw values that mean "no value". A reading is a `maybe`.
template <std::int64_t... Codes> struct or_none {};
/// Multiplies by ten to the power of `Row`, an integer of the same device from -10 to 10. Any other exponent means "no
/// value", so a reading is a `maybe`. Both rows are named in one read.
template <const auto& Row> struct ten_to {};
/// Multiplies by `Row`, an integer of the same device. Both rows are named in one read.
template <const auto& Row> struct times_row {};
/// The order of the words of this row, where the device has another order.
struct high_word_first {};
struct low_word_first {};
/// The low byte of each word comes first.
struct low_byte_first {};

} // namespace servobus
