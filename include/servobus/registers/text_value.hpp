// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Text in registers: a serial number, a model, a maker. Two characters lie in a register, the first one in the high
// byte unless the row says `low_byte_first`.
//
//     constexpr text_of<4> model{"SDM120"};
//     static_assert(model == "SDM120" && model.size() == 6);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/registers/value_types.hpp>

namespace servobus {

/// Text of `Words` registers. The characters are those of the device; most devices have ASCII.
template <std::size_t Words> class text_of {
    static_assert(Words >= 1 && Words <= 123, "one frame carries a text: 1 to 123 registers");

  public:
    static constexpr std::size_t longest = 2 * Words;

    constexpr text_of() = default;
    /// A constant. One that is too long does not compile.
    template <std::size_t N>
    consteval text_of(const char (&constant)[N]) { // NOLINT: implicit, a text is a text
        static_assert(N - 1 <= longest, "this text is longer than its registers");
        for (std::size_t i = 0; i + 1 < N; ++i) letters_[i] = constant[i];
    }
    /// The text of registers, word `i` of which is `word_at(i)`: up to the first zero, without the blanks at its end.
    template <class WordAt> static constexpr text_of from(const WordAt& word_at, bool is_low_byte_first) {
        text_of t;
        std::size_t used = 0; // up to the last character that is no blank
        for (std::size_t i = 0; i < longest; ++i) {
            const u16 word = word_at(i / 2);
            const bool is_high = (i % 2 == 0) != is_low_byte_first;
            const auto c = static_cast<std::uint8_t>(is_high ? word >> 8 : word & 0xFF);
            if (c == 0) break;
            t.letters_[i] = static_cast<char>(c);
            if (c != ' ') used = i + 1;
        }
        for (std::size_t i = used; i < longest; ++i) t.letters_[i] = '\0';
        return t;
    }
    /// Stores the registers into a frame, from byte `at` on, with zeros behind the text.
    constexpr void store(byte_buffer frame, std::size_t at, bool is_low_byte_first) const {
        for (std::size_t i = 0; i < longest; ++i)
            frame[at + (i ^ (is_low_byte_first ? 1u : 0u))] = static_cast<std::uint8_t>(letters_[i]);
    }
    /// A text of run time. False, and no text, if it is longer than the registers.
    constexpr bool assign(const char* text) {
        *this = {};
        for (std::size_t i = 0; text[i] != '\0'; ++i) {
            if (i == longest) {
                *this = {};
                return false;
            }
            letters_[i] = text[i];
        }
        return true;
    }

    constexpr const char* c_str() const { return letters_; }
    constexpr std::size_t size() const {
        std::size_t n = 0;
        while (letters_[n] != '\0') ++n;
        return n;
    }
    friend constexpr bool operator==(const text_of& a, const text_of& b) = default;
    friend constexpr bool operator==(const text_of& a, const char* b) {
        std::size_t i = 0;
        for (; a.letters_[i] != '\0'; ++i) {
            if (a.letters_[i] != b[i]) return false;
        }
        return b[i] == '\0';
    }

  private:
    char letters_[longest + 1]{};
};

} // namespace servobus
