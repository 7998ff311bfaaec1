// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Buffers of bytes, and the big-endian 16-bit words in them, as Modbus transmits them. Every header that
// builds or parses frames includes it; programs include it for `bytes`, `byte_buffer` and `hex()`.
//
//     static_assert(load_word(hex("01 06 20 0E 00 08 E2 0F"), 2) == 0x200E);
//
// Words are assembled from bytes, so results do not depend on the host's byte order or alignment.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/slice.hpp>

namespace servobus {

/// A read-only view of bytes; `byte_buffer` is a writable one.
using bytes = slice<const std::uint8_t>;
using byte_buffer = slice<std::uint8_t>;

/// The big-endian word at `from[at]` and `from[at + 1]`. Both bytes must lie inside `from`.
constexpr std::uint16_t load_word(bytes from, std::size_t at) {
    const bytes word = from.subspan(at, 2); // with a common base compilers use one load
    if constexpr (sizeof(std::size_t) >= 8) return static_cast<std::uint16_t>(word[0] << 8u | word[1]);
    // GCC makes a load and a byte swap of the form above: longer where a core can load only single bytes.
    return static_cast<std::uint16_t>(word[0] * 256u + word[1]);
}

/// Stores `word` big-endian at `to[at]` and `to[at + 1]`. Both bytes must lie inside `to`.
constexpr void store_word(byte_buffer to, std::size_t at, std::uint16_t word) {
    if constexpr (sizeof(std::size_t) >= 8 && std::endian::native == std::endian::little) {
        if (!std::is_constant_evaluated()) { // clang does not join two bytes that are read soon after
            const std::uint16_t swapped = __builtin_bswap16(word);
            __builtin_memcpy(to.data() + at, &swapped, 2);
            return;
        }
    }
    to[at] = static_cast<std::uint8_t>(word >> 8);
    to[at + 1] = static_cast<std::uint8_t>(word & 0xFFu);
}

/// A view of consecutive big-endian words in a frame, such as the payload of a read response. It copies
/// nothing.
class words_view {
  public:
    constexpr words_view() = default;
    /// `payload` holds two bytes for each word; an odd last byte is ignored.
    constexpr explicit words_view(bytes payload) : payload_{payload} {}

    constexpr std::size_t size() const { return payload_.size() / 2; }
    constexpr std::uint16_t operator[](std::size_t i) const { return load_word(payload_, 2 * i); }

    /// Copies the first `to.size()` words into `to`. The view must hold at least that many.
    constexpr void copy_to(slice<std::uint16_t> to) const {
        const bytes from = payload_.first(2 * to.size());
        std::size_t i = 0;
        if constexpr (sizeof(std::size_t) >= 8 && std::endian::native == std::endian::little) {
            constexpr std::uint64_t low = 0x00FF'00FF'00FF'00FF;
            for (; i + 4 <= to.size() && !std::is_constant_evaluated(); i += 4) { // four words at a time
                std::uint64_t words = 0;
                __builtin_memcpy(&words, &from[2 * i], 8);
                words = (words & low) << 8 | (words >> 8 & low);
                __builtin_memcpy(&to[i], &words, 8);
            }
        }
        for (; i < to.size(); ++i) to[i] = load_word(from, 2 * i);
    }

  private:
    bytes payload_{};
};

/// The value 0..15 of a hexadecimal digit; FFh for any other character.
constexpr std::uint8_t hex_digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<std::uint8_t>(c - '0');
    if (c >= 'A' && c <= 'F') return static_cast<std::uint8_t>(c - 'A' + 10);
    if (c >= 'a' && c <= 'f') return static_cast<std::uint8_t>(c - 'a' + 10);
    return 0xFF;
}

namespace detail {
void a_frame_in_hex_has_two_digits_for_each_byte(); // never defined: the error prints its name
} // namespace detail

/// Bytes in hexadecimal as a manual prints them, `hex("01 06 20 0E 00 08 E2 0F")`. Spaces may separate bytes.
/// Any other character, and a byte of one digit, does not compile.
template <std::size_t Chars> struct hex_text {
    std::uint8_t data[(Chars + 1) / 2]{};
    std::size_t size = 0;

    consteval hex_text(const char (&text)[Chars]) { // NOLINT: implicit, so that hex("...") reads as data
        for (std::size_t i = 0; i + 1 < Chars;) {
            if (text[i] == ' ') {
                ++i;
                continue;
            }
            const std::uint8_t high = hex_digit(text[i]);
            const std::uint8_t low = i + 2 < Chars ? hex_digit(text[i + 1]) : std::uint8_t{0xFF};
            if (high == 0xFF || low == 0xFF) detail::a_frame_in_hex_has_two_digits_for_each_byte();
            data[size++] = static_cast<std::uint8_t>(high << 4 | low);
            i += 2;
        }
    }

    constexpr operator bytes() const { return bytes{data, size}; } // NOLINT: a frame is its bytes
};

/// Converts bytes in hexadecimal at compile time; see `hex_text`.
template <std::size_t Chars> consteval hex_text<Chars> hex(const char (&text)[Chars]) { return {text}; }

/// True if both buffers have the same size and content.
constexpr bool same_bytes(bytes a, bytes b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] != b[i]) return false;
    }
    return true;
}

} // namespace servobus
