// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Formats a line of text into the caller's memory: words, decimal numbers, hexadecimal. It allocates nothing
// and truncates what does not fit. The headers that format registers and frames include it; programs include
// it for tools and traces.
//
//     constexpr auto line = [] {
//         std::array<char, 16> room{};
//         (text_writer{room} << "speed ").scaled(125, 1);
//         return room; // "speed 12.5"
//     }();
#pragma once

#include <servobus/core/cxx20.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace servobus {

/// Writes text into `room`, from its beginning and without a terminating zero. Text that does not fit is
/// truncated and ends in "...".
class text_writer {
  public:
    constexpr explicit text_writer(std::span<char> room) : room_{room} {}

    /// Number of characters written, at most the size of `room`.
    constexpr std::size_t size() const { return size_; }
    /// True if text was truncated.
    constexpr bool is_cut() const { return is_cut_; }

    constexpr text_writer& operator<<(char c) {
        if (is_cut_) return *this;
        if (size_ < room_.size()) {
            room_[size_++] = c;
            return *this;
        }
        is_cut_ = true;
        for (std::size_t i = size_ < 3 ? 0 : size_ - 3; i < size_; ++i) room_[i] = '.';
        return *this;
    }

    constexpr text_writer& operator<<(const char* words) {
        for (; *words != '\0'; ++words) *this << *words;
        return *this;
    }

    /// Writes an integer in decimal.
    constexpr text_writer& number(std::int64_t value) { return scaled(value, 0); }

    /// Writes `value` in decimal with `decimals` digits after the point: `scaled(125, 1)` writes 12.5.
    constexpr text_writer& scaled(std::int64_t value, unsigned decimals) {
        std::array<char, 40> digits{};
        std::size_t count = 0;
        auto rest = static_cast<std::uint64_t>(value);
        if (value < 0) {
            *this << '-';
            rest = 0 - rest;
        }
        while ((rest != 0 || count <= decimals) && count < digits.size()) {
            digits[count++] = static_cast<char>('0' + static_cast<char>(rest % 10));
            rest /= 10;
        }
        while (count != 0) {
            *this << digits[--count];
            if (count == decimals && count != 0) *this << '.';
        }
        return *this;
    }

    /// Writes the lowest `digits` hexadecimal digits of `value`, in upper case and without 0x.
    constexpr text_writer& hex(std::uint32_t value, unsigned digits) {
        for (unsigned i = digits; i != 0; --i) *this << "0123456789ABCDEF"[value >> (4 * (i - 1)) & 0xFu];
        return *this;
    }
    /// Writes a 16-bit word with its prefix: `0x200E`.
    constexpr text_writer& hex_word(std::uint16_t value) {
        *this << "0x";
        return hex(value, 4);
    }

  private:
    std::span<char> room_;
    std::size_t size_ = 0;
    bool is_cut_ = false;
};

} // namespace servobus
