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
/// A whole number, decimal or 0x…; nothing else may stand around it.
std::optional<std::int64_t> parse_integer(std::string_view text);
/// An address as programs or manuals write it: 0x2088, 8328, 2088h.
std::optional<std::int64_t> parse_address(std::string_view text);

} // namespace tool
