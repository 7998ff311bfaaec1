// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The words of a row, the highest first and the high byte first in each, as numbers and texts. A part of a register has
// one word, with its bits in their place and zeros around them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/registers/row_value.hpp>

namespace tool {

using servobus::u16;
using servobus::u32;

/// The words that encode a row's bits; see `servobus::bits_of_words`.
std::vector<u16> words_of_bits(const servobus::entry& row, std::uint64_t bits);
/// The words of a number in counts, of a float in whole units. The row is no text.
std::vector<u16> words_of(const servobus::entry& row, std::int64_t number);
/// The number in counts. The row is neither a text nor a float.
std::int64_t number_of(const servobus::entry& row, std::span<const u16> words);
servobus::row_value value_of_words(const servobus::entry& row, std::span<const u16> words);

/// False for what may not be written: a value outside the range, a raw value that means none, a digit above 9.
bool takes_words(const servobus::entry& row, std::span<const u16> words);

/// The words as `servobus read` prints them: `12.5 A`.
/// `scaled_by`: the name of the row that scales it, for a scale that is not known.
std::string words_text(const servobus::entry& row, std::span<const u16> words,
                       const servobus::row_scale& scale, const char* scaled_by = "its scale");
std::string words_text(const servobus::entry& row, std::span<const u16> words);
std::string number_text(const servobus::entry& row, std::int64_t number);

/// The words as a file of parameters has them, which give the same bits again: a number in counts, a float, a text in
/// quotes.
std::string plain_text(const servobus::entry& row, std::span<const u16> words);
/// And back; none if it is no such text.
std::optional<std::vector<u16>> parse_plain(const servobus::entry& row, std::string_view text);

/// The bits of a finite float that is written in the row's unit; none if it is no number, or too large.
std::optional<std::uint64_t> parse_float(const servobus::entry& row, std::string_view text);
/// The words of a text, which may be in quotes, with zeros behind it. None if it is too long, or if a backslash in it
/// begins no character such as \x0A.
std::optional<std::vector<u16>> parse_text(const servobus::entry& row, std::string_view text);

} // namespace tool
