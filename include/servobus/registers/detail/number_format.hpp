// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The encodings of numbers beyond integers of one or two registers: from raw bits to a number, and back.
// registers/values.hpp includes it.
//
//     static_assert(detail::number_format<bcd<1>>::from(0x1234, 16) == 1234);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/bytes.hpp>
#include <servobus/registers/reg.hpp>
#include <servobus/registers/value_types.hpp>

namespace servobus::detail {

/// The lowest `width` bits.
constexpr u64 bits_below(unsigned width) { return width == 64 ? ~u64{0} : (u64{1} << width) - 1; }

/// A range of 64 bits with a sign; a u64 beyond it is written and read as it is.
struct number_range {
    std::int64_t low;
    std::int64_t high;
};

/// An unsigned integer or an enumeration. `width`: bits that the number has.
template <class T> struct number_format {
    using number = T;
    static constexpr bool is_number(u64, unsigned) { return true; }
    static constexpr number from(u64 raw, unsigned) { return static_cast<number>(raw); }
    static constexpr u64 to(number v) { return static_cast<u64>(v); }
    static constexpr number_range limits(unsigned width) {
        return {0, static_cast<std::int64_t>(bits_below(width == 64 ? 63 : width))};
    }
};
template <std::signed_integral T> struct number_format<T> {
    using number = T;
    static constexpr bool is_number(u64, unsigned) { return true; }
    static constexpr number from(u64 raw, unsigned width) {
        const u64 top = u64{1} << (width - 1);
        return static_cast<number>(static_cast<std::int64_t>((raw ^ top) - top));
    }
    static constexpr u64 to(number v) { return static_cast<u64>(v); }
    static constexpr number_range limits(unsigned width) {
        const auto most = static_cast<std::int64_t>(bits_below(width - 1));
        return {-most - 1, most};
    }
};
template <std::floating_point T> struct number_format<T> {
    using number = T;
    using raw_type = std::conditional_t<sizeof(T) == 4, u32, u64>;
    static constexpr bool is_number(u64, unsigned) { return true; }
    static constexpr number from(u64 raw, unsigned) {
        return __builtin_bit_cast(T, static_cast<raw_type>(raw));
    }
    static constexpr u64 to(number v) { return __builtin_bit_cast(raw_type, v); }
    static constexpr number_range limits(unsigned) {
        return {lowest<std::int64_t> + 1, highest<std::int64_t>}; // in whole units
    }
};
template <std::size_t Words> struct number_format<bcd<Words>> {
    using has_wrong_digits = void; // so a reading may be none
    using number = std::conditional_t<Words == 1, u16, u32>;
    static constexpr bool is_number(u64 raw, unsigned) {
        for (; raw != 0; raw >>= 4) {
            if ((raw & 0xF) > 9) return false;
        }
        return true;
    }
    static constexpr number from(u64 raw, unsigned width) {
        u32 n = 0;
        for (unsigned at = width; at != 0;) {
            at -= at % 4 == 0 ? 4 : at % 4;
            n = 10 * n + static_cast<u32>(raw >> at & 0xF);
        }
        return static_cast<number>(n);
    }
    static constexpr u64 to(number v) {
        u64 raw = 0;
        u32 rest = v;
        for (unsigned at = 0; rest != 0; at += 4) {
            raw |= u64{rest % 10} << at;
            rest /= 10;
        }
        return raw;
    }
    static constexpr number_range limits(unsigned width) {
        std::int64_t above = 1;
        for (unsigned at = 0; at + 4 <= width; at += 4) above *= 10;
        return {0, above * (std::int64_t{1} << width % 4) - 1};
    }
};
template <std::size_t Words> struct number_format<sign_magnitude<Words>> {
    using number = std::conditional_t<Words == 1, i16, i32>;
    static constexpr bool is_number(u64, unsigned) { return true; }
    static constexpr number from(u64 raw, unsigned width) {
        const u64 sign = u64{1} << (width - 1);
        const auto magnitude = static_cast<i32>(raw & (sign - 1));
        return static_cast<number>((raw & sign) != 0 ? -magnitude : magnitude);
    }
    static constexpr u64 to(number v) {
        constexpr u64 sign = u64{1} << (16 * Words - 1);
        return v < 0 ? sign | static_cast<u64>(-std::int64_t{v}) : static_cast<u64>(v);
    }
    static constexpr number_range limits(unsigned width) {
        const auto most = static_cast<std::int64_t>(bits_below(width - 1));
        return {-most, most};
    }
};

constexpr u16 swapped(u16 word) { return static_cast<u16>(word << 8 | word >> 8); }

/// The raw bits of a value whose word `i`, in the order of the line, is `word_at(i)`.
template <std::size_t Words, class WordAt>
constexpr u64 join_value(const WordAt& word_at, word_order order, bool is_low_byte_first) {
    u64 raw = 0;
    for (std::size_t i = 0; i < Words; ++i) {
        const u16 word = word_at(order == word_order::low_first ? Words - 1 - i : i);
        raw = raw << 16 | (is_low_byte_first ? swapped(word) : word);
    }
    return raw;
}
/// Stores the words of a value into a frame, from byte `at` on.
template <std::size_t Words>
constexpr void store_value(byte_buffer frame, std::size_t at, u64 raw, word_order order,
                           bool is_low_byte_first) {
    for (std::size_t i = 0; i < Words; ++i) {
        const auto word = static_cast<u16>(raw >> 16 * (Words - 1 - i));
        store_word(frame, at + 2 * (order == word_order::low_first ? Words - 1 - i : i),
                   is_low_byte_first ? swapped(word) : word);
    }
}

/// `a * b`, limited to 64 bits with a sign. `b` has 32 bits.
constexpr std::int64_t limited_product(std::int64_t a, std::int64_t b) {
    const bool is_negative = (a < 0) != (b < 0);
    const u64 x = a < 0 ? u64{0} - static_cast<u64>(a) : static_cast<u64>(a);
    const u64 y = b < 0 ? u64{0} - static_cast<u64>(b) : static_cast<u64>(b);
    const u64 low = (x & 0xFFFF'FFFF) * y;
    const u64 high = (x >> 32) * y + (low >> 32);
    constexpr u64 most = u64{1} << 63;
    const u64 product = high >> 31 != 0 ? most : high << 32 | (low & 0xFFFF'FFFF);
    if (is_negative) return static_cast<std::int64_t>(u64{0} - product);
    return product == most ? highest<std::int64_t> : static_cast<std::int64_t>(product);
}

} // namespace servobus::detail
