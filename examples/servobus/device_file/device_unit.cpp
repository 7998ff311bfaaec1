// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_unit.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "../words/csv.hpp"
#include "../words/nearest.hpp"
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

constexpr unsigned last_measure = static_cast<unsigned>(servobus::measure::cubic_metre_per_hour);

std::string small_letters(std::string_view text) {
    std::string all{text};
    std::ranges::transform(
        all, all.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return all;
}

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

struct prefix {
    std::string_view sign;
    std::string_view unit_sign; // in front of the unit that is named instead
    std::string_view scale;
};
// MWh is 1000 kWh rather than 1000000 Wh, which is beyond a scale.
constexpr prefix prefixes[] = {{"M", "k", "a scale 1000 times as large"},
                               {"M", "", "a scale 1000000 times as large"},
                               {"k", "", "a scale 1000 times as large"},
                               {"h", "", "a scale 100 times as large"},
                               {"d", "", "1/10 of the scale"},
                               {"c", "", "1/100 of the scale"},
                               {"m", "", "1/1000 of the scale"}};

// `; write var, and a scale 1000 times as large` for kvar; empty if it is no unit of the list with a prefix.
std::string without_prefix(std::string_view symbol, std::span<const std::string_view> known) {
    for (const prefix& p : prefixes) {
        if (!symbol.starts_with(p.sign)) continue;
        const std::string rest = std::string{p.unit_sign} + std::string{symbol.substr(p.sign.size())};
        for (const std::string_view unit : known) {
            if (!unit.empty() && small_letters(unit) == small_letters(rest))
                return "; write " + std::string{unit} + ", and " + std::string{p.scale};
        }
    }
    return {};
}

std::string unknown_unit(std::string_view symbol, std::span<const std::string_view> known) {
    const std::string complaint = "unknown unit " + csv::shown(symbol);
    for (const usual_symbol& u : usual_symbols) {
        if (symbol == u.usual) return complaint + "; did you mean " + std::string{u.ours} + "?";
    }
    const bool is_known_but_for_capitals = std::ranges::any_of(
        known, [&](std::string_view unit) { return small_letters(unit) == small_letters(symbol); });
    if (const std::string hint = without_prefix(symbol, known); !hint.empty() && !is_known_but_for_capitals)
        return complaint + hint;
    std::string all = "; known: ";
    for (const std::string_view unit : known) {
        if (!unit.empty()) all += (all.ends_with(": ") ? "" : ", ") + std::string{unit};
    }
    return complaint + did_you_mean(symbol, known, all + "; a plain number has none");
}

} // namespace

std::string parse_unit(std::string_view scale, std::string_view symbol, servobus::unit& of_count) {
    std::optional<servobus::unit> u = servobus::unit{};
    if (!scale.empty()) u = parse_scale(scale);
    if (!u) return "scale takes 0.1, 25, 1/3 or the like, of numbers up to 65535, not " + csv::shown(scale);
    std::vector<std::string_view> known;
    for (unsigned i = 0; i <= last_measure; ++i) {
        const auto m = static_cast<servobus::measure>(i);
        known.emplace_back(servobus::symbol(m));
        if (known.back() == symbol) u->of = m;
    }
    if (!symbol.empty() && u->of == servobus::measure::none) return unknown_unit(symbol, known);
    if (u->of == servobus::measure::none && !u->is_plain())
        return "scale " + csv::shown(scale) + " needs a unit; that of a plain ratio is times";
    of_count = *u;
    return {};
}

} // namespace tool
