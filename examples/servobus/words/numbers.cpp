// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "numbers.hpp"

#include <charconv>
#include <cstdio>

namespace tool {

std::string hex_word(std::uint16_t word) {
    char text[8];
    (void)std::snprintf(text, sizeof text, "0x%04X", static_cast<unsigned>(word));
    return text;
}

std::string counted(std::size_t n, const char* thing) {
    return std::to_string(n) + ' ' + thing + (n == 1 ? "" : "s");
}

std::optional<std::uint64_t> parse_magnitude(std::string_view text) {
    int base = 10;
    if (text.starts_with("0x") || text.starts_with("0X")) {
        text.remove_prefix(2);
        base = 16;
    }
    std::uint64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value, base);
    if (text.empty() || error != std::errc{} || stopped != end) return std::nullopt;
    return value;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
    const bool is_negative = text.starts_with('-');
    const std::optional<std::uint64_t> size = parse_magnitude(text.substr(is_negative ? 1 : 0));
    if (!size || *size > INT64_MAX) return std::nullopt;
    const auto magnitude = static_cast<std::int64_t>(*size);
    return is_negative ? -magnitude : magnitude;
}

std::optional<std::int64_t> parse_address(std::string_view text) {
    if (text.size() < 2 || (text.back() != 'h' && text.back() != 'H')) return parse_integer(text);
    text.remove_suffix(1);
    const bool is_hex = text.find_first_not_of("0123456789abcdefABCDEF") == text.npos;
    return is_hex ? parse_integer("0x" + std::string{text}) : std::nullopt;
}

} // namespace tool
