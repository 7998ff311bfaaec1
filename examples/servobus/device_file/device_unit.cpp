// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_unit.hpp"

#include <algorithm>
#include <numeric>
#include <optional>

#include "../words/csv.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

std::uint64_t magnitude(std::string_view digits) {
    const std::optional<std::int64_t> number = parse_integer(digits);
    const bool is_plain =
        !digits.empty() && digits.size() <= 12 && digits.find_first_not_of("0123456789") == digits.npos;
    return is_plain && number ? static_cast<std::uint64_t>(*number) : 0;
}

// `0.1`, `25`, `1/3`; none if it is no such number, or has more than 16 bits above or below.
std::optional<servobus::unit> parse_scale(std::string_view text) {
    std::uint64_t above = 0;
    std::uint64_t below = 1;
    if (const std::size_t slash = text.find('/'); slash != text.npos) {
        above = magnitude(text.substr(0, slash));
        below = magnitude(text.substr(slash + 1));
    } else {
        const std::size_t point = std::min(text.find('.'), text.size());
        const std::string_view decimals = text.substr(std::min(point + 1, text.size()));
        if (point == 0 || (point != text.size() && decimals.empty()) || decimals.size() > 6)
            return std::nullopt;
        above = magnitude(std::string{text.substr(0, point)} + std::string{decimals});
        for (std::size_t i = 0; i < decimals.size(); ++i) below *= 10;
        const std::uint64_t common = std::gcd(above, below);
        if (common != 0) {
            above /= common;
            below /= common;
        }
    }
    if (above == 0 || below == 0 || above > 0xFFFF || below > 0xFFFF) return std::nullopt;
    return servobus::unit{servobus::measure::none, static_cast<std::uint16_t>(above),
                          static_cast<std::uint16_t>(below)};
}

constexpr std::size_t longest_symbol = 31;

// Symbols that many write for a unit of the list.
struct usual_symbol {
    std::string_view usual, ours;
};
constexpr usual_symbol usual_symbols[] = {{"rpm", "r/min"},
                                          {"C", "degC"},
                                          {"\xC2\xB0"
                                           "C",
                                           "degC"},
                                          {"\xC2\xB0", "deg"},
                                          {"m\xC2\xB3", "m3"},
                                          {"m\xC2\xB3/h", "m3/h"}};

// Text of UTF-8, without what the cells and records of the tool cannot hold.
bool is_symbol(std::string_view text) {
    const auto is_good = [](char c) {
        return static_cast<unsigned char>(c) >= ' ' && c != '"' && c != ',' && c != 0x7F;
    };
    return text.size() <= longest_symbol && std::ranges::all_of(text, is_good);
}

} // namespace

std::string parse_unit(std::string_view scale, std::string_view symbol, servobus::unit& of_count,
                       std::string& own_symbol) {
    std::optional<servobus::unit> u = servobus::unit{};
    if (!scale.empty()) u = parse_scale(scale);
    if (!u) return "scale takes 0.1, 25, 1/3 or the like, of numbers up to 65535, not " + csv::shown(scale);
    for (const usual_symbol& known : usual_symbols) {
        if (symbol == known.usual) symbol = known.ours;
    }
    for (unsigned i = 0; i < static_cast<unsigned>(servobus::measure::device_unit); ++i) {
        const auto m = static_cast<servobus::measure>(i);
        if (servobus::symbol(m) == symbol) u->of = m;
    }
    if (!symbol.empty() && u->of == servobus::measure::none) {
        if (!is_symbol(symbol))
            return "unit takes a symbol of at most " + std::to_string(longest_symbol) +
                   " bytes without commas and quotes, not " + csv::shown(symbol);
        u->of = servobus::measure::device_unit;
        own_symbol = symbol;
    }
    if (u->of == servobus::measure::none && !u->is_plain())
        return "scale " + csv::shown(scale) + " needs a unit; that of a plain ratio is times";
    of_count = *u;
    return {};
}

} // namespace tool
