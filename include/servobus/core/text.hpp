// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line of text in the caller's memory, for tools and traces: words, numbers, hex. It allocates nothing and
// cuts what does not fit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace servobus {

/// Writes text from the beginning of `room` on, without a terminating zero. Text that does not fit is cut and
/// ends in "...".
class text_writer {
  public:
    constexpr explicit text_writer(std::span<char> room) : room_{room} {}

    /// Characters written, at most the room's size.
    constexpr std::size_t size() const { return size_; }
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

    /// A whole number.
    constexpr text_writer& number(std::int64_t value) { return scaled(value, 0); }

    /// `value` tenths, hundredths … with `decimals` digits behind the point: `scaled(125, 1)` is 12.5.
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

    /// `digits` hex digits of `value`, the lowest ones, in capitals and without 0x.
    constexpr text_writer& hex(std::uint32_t value, unsigned digits) {
        for (unsigned i = digits; i != 0; --i) *this << "0123456789ABCDEF"[value >> (4 * (i - 1)) & 0xFu];
        return *this;
    }
    /// A word as the manuals print it: `0x200E`.
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
