// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Whole numbers, counts and addresses as text, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tool {

std::string hex_word(std::uint16_t word);
/// `1 write`, `2 writes`.
std::string counted(std::size_t n, const char* thing);
/// A whole number of at most 64 bits without a sign, decimal or 0x…; nothing else may stand around it.
std::optional<std::uint64_t> parse_magnitude(std::string_view text);
/// The same with a sign; of at most 63 bits.
std::optional<std::int64_t> parse_integer(std::string_view text);
/// An address as programs or manuals write it: 0x2088, 8328, 2088h.
std::optional<std::int64_t> parse_address(std::string_view text);

} // namespace tool
