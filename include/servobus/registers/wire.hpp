// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How values are encoded in 16-bit registers: integers of one or two words, enumerations, and classes that
// unpack one word (bit fields, two axes in one register). The other headers of registers/ include it;
// programs include it to define types for the registers of a device of their own.
//
//     static_assert(join_words(0x0001, 0x86A0, word_order::high_first) == 100'000);
//     static_assert(from_bits<left_right<std::int8_t>>(0x23FF).right == -1);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace servobus {

using u16 = std::uint16_t;
using i16 = std::int16_t;
using u32 = std::uint32_t;
using i32 = std::int32_t;

/// The order of the two words of a 32-bit value.
enum class word_order : std::uint8_t {
    unknown,    ///< the drive can switch it, and it has not been read: 32-bit values are refused
    high_first, ///< the high word is at the lower address
    low_first,  ///< the low word is at the lower address
};

// The compiler checks these concepts for a few dozen types per map, so they check little.

/// A class that holds the unpacked fields of one word: `T::from_word` unpacks, `to_word` packs them.
template <class T>
concept packed_word = std::is_class_v<T> && requires(const T& v, T& from, u16 word) {
    from = T::from_word(word);
    word = v.to_word();
};

namespace detail {
template <class T> inline constexpr bool is_wire_integer = false;
template <> inline constexpr bool is_wire_integer<u16> = true;
template <> inline constexpr bool is_wire_integer<i16> = true;
template <> inline constexpr bool is_wire_integer<u32> = true;
template <> inline constexpr bool is_wire_integer<i32> = true;

template <class T> inline constexpr std::size_t words_in = 1;
template <> inline constexpr std::size_t words_in<u32> = 2;
template <> inline constexpr std::size_t words_in<i32> = 2;

// True for a type whose values are counts: integers.
template <class T> inline constexpr bool is_counted = is_wire_integer<T>;
// The hooks of registers/values.hpp. True for its types, whose values a codec makes.
template <class T> inline constexpr bool has_codec = false;
// True if the codec takes the words of a frame, not 32 bits: of more words, of an order of its own, of a part.
template <class T> inline constexpr bool takes_words = false;
// True for some bits of a register, of which other rows may be parts too.
template <class T> inline constexpr bool is_part = false;
} // namespace detail

/// An integer of one or two registers: `u16`, `i16`, `u32`, `i32`.
template <class T>
concept wire_integer = detail::is_wire_integer<T>;

/// An enumeration of 16 bits, the width of its register, so that values without a name are kept unchanged.
template <class T>
concept wire_enum = std::is_enum_v<T> && sizeof(T) == 2;

/// The types that a register's value may have.
template <class T>
concept wire_value = wire_integer<T> || wire_enum<T> || packed_word<T>;

/// The number of 16-bit words of a `T`.
template <wire_value T> constexpr std::size_t words_of() { return detail::words_in<T>; }

/// Decodes the raw bits of one word, or of two joined words.
template <wire_value T> constexpr T from_bits(u32 bits) {
    if constexpr (packed_word<T>) {
        return T::from_word(static_cast<u16>(bits));
    } else if constexpr (wire_enum<T>) {
        return static_cast<T>(static_cast<std::underlying_type_t<T>>(bits));
    } else {
        return static_cast<T>(static_cast<std::make_unsigned_t<T>>(bits));
    }
}

/// Encodes a value as raw bits; a value of one word uses the low half.
template <wire_value T> constexpr u32 to_bits(T value) {
    if constexpr (packed_word<T>) {
        return value.to_word();
    } else if constexpr (wire_enum<T>) {
        return static_cast<u16>(value);
    } else {
        return static_cast<std::make_unsigned_t<T>>(value);
    }
}

/// Joins the two words of a 32-bit value; `first` is the word at the lower address.
constexpr u32 join_words(u16 first, u16 second, word_order order) {
    return order == word_order::low_first ? u32{second} << 16 | first : u32{first} << 16 | second;
}

/// The two words of a 32-bit value; `first` is the word at the lower address.
struct word_pair {
    u16 first;
    u16 second;
    friend constexpr bool operator==(word_pair, word_pair) = default;
};

/// Splits 32 bits into two words in the given word order.
constexpr word_pair split_words(u32 bits, word_order order) {
    const auto high = static_cast<u16>(bits >> 16);
    const auto low = static_cast<u16>(bits & 0xFFFFu);
    return order == word_order::low_first ? word_pair{low, high} : word_pair{high, low};
}

/// Values of two axes in one word: the high byte is for the left axis, the low byte for the right one.
template <class T> struct left_right {
    T left{};
    T right{};

    static constexpr left_right from_word(u16 word) {
        return {static_cast<T>(static_cast<std::uint8_t>(word >> 8)),
                static_cast<T>(static_cast<std::uint8_t>(word & 0xFFu))};
    }
    constexpr u16 to_word() const {
        return static_cast<u16>(static_cast<unsigned>(static_cast<std::uint8_t>(left)) << 8 |
                                static_cast<std::uint8_t>(right));
    }
    friend constexpr bool operator==(left_right, left_right) = default;
};

} // namespace servobus
