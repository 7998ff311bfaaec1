// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_names.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include <servobus/registers/row_value.hpp>

#include "../words/csv.hpp"
#include "../words/numbers.hpp"
#include "named_values.hpp"

namespace tool {
namespace {

using servobus::entry;

constexpr std::uint32_t code_mask = 0xFFFF; // the mask of a code

// The bits of a code: a number of the row's type, without its offset, or in hexadecimal the bits themselves.
std::optional<std::uint32_t> parse_code(std::string_view text, const device_row& row) {
    const std::optional<std::int64_t> number = parse_integer(text);
    if (!number) return std::nullopt;
    if (row.table == servobus::table::coils) { // above 1: a word that function 05 sends
        const bool is_word = *number >= 0 && *number <= 0xFFFF && *number != 0xFF00;
        return is_word ? std::optional{static_cast<std::uint32_t>(*number)} : std::nullopt;
    }
    if (is_of_bits(row.table))
        return *number == 0 || *number == 1 ? std::optional{static_cast<std::uint32_t>(*number)}
                                            : std::nullopt;
    const entry& e = row.entry;
    const bool is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
    if (is_hexadecimal && static_cast<std::uint64_t>(*number) <= all_bits_of(e))
        return static_cast<std::uint32_t>(*number);
    const servobus::number_bits found =
        with_plain_number(e, [&](const entry& plain) { return bits_of_number(plain, *number); });
    return found.fits ? std::optional{static_cast<std::uint32_t>(found.bits)} : std::nullopt;
}

// A text that is typed after REG= must mean one thing.
std::string judge_name(const cell_name& n, const entry& e) {
    const auto is_good = [](char c) { return c >= ' ' && c <= '~' && c != '+' && c != ',' && c != '"'; };
    if (n.name.empty()) return "a code or bit has no name";
    if (n.name.size() > servobus::label::longest)
        return "the name " + csv::shown(n.name) + " has more than " +
               std::to_string(servobus::label::longest) + " characters";
    if (!std::ranges::all_of(n.name, is_good))
        return "the name " + csv::shown(n.name) + " has a character that is not ASCII, or one of + , \"";
    if (n.name.starts_with("0x") || n.name.starts_with("0X"))
        return "the name " + csv::shown(n.name) + " would be read as a number";
    const std::optional<std::int64_t> number = parse_integer(n.name);
    const bool is_own = n.mask == code_mask && number == value_of(e, n.value).count();
    if (number && !is_own && e.limits.contains(*number))
        return "the name " + csv::shown(n.name) + " is also another value of the register";
    return {};
}

// `pulse=2` for `2=pulse`
bool is_reversed(std::string_view place, std::string_view name) {
    const bool is_bit = place.starts_with('b') && parse_integer(place.substr(1));
    return !place.empty() && parse_integer(name) && !parse_integer(place) && !is_bit &&
           place.find(':') == place.npos;
}

// `3=enable`, `b3=ready`, `0x00C0:0x0040=locked`
std::string one_name(std::string_view part, device_row& row) {
    const bool is_bit = is_of_bits(row.table);
    const std::size_t equals = part.find('=');
    if (equals == part.npos)
        return "names takes 3=enable, b3=ready, 0x00C0:0x0040=locked, hex or halves, not " + csv::shown(part);
    const std::string_view place = csv::trimmed(part.substr(0, equals));
    cell_name n{code_mask, 0, csv::trimmed(part.substr(equals + 1))};
    if (is_reversed(place, n.name)) {
        return "names takes CODE=name, as in " + csv::shown(std::string{n.name} + '=' + std::string{place}) +
               ", not " + csv::shown(part);
    }
    if (const std::size_t colon = place.find(':'); !is_bit && colon != place.npos) {
        const std::optional<std::int64_t> mask = parse_integer(place.substr(0, colon));
        const std::optional<std::int64_t> value = parse_integer(place.substr(colon + 1));
        const auto all = static_cast<std::int64_t>(all_bits_of(row.entry));
        if (!mask || !value || *mask < 1 || *mask > all || *value < 0 || (*value & ~*mask) != 0)
            return csv::shown(place) + " is no MASK:VALUE of bits inside the mask";
        if (*mask == code_mask && all > code_mask)
            return csv::shown(place) + " is the low word of a pair: name its bits";
        n.mask = *mask == all ? code_mask : static_cast<std::uint32_t>(*mask);
        n.value = static_cast<std::uint32_t>(*value);
    } else if (!is_bit && place.starts_with('b')) {
        const std::optional<std::int64_t> bit = parse_integer(place.substr(1));
        const unsigned width = width_of(row.entry);
        if (!bit || *bit < 0 || *bit >= width)
            return csv::shown(place) + " is no bit from b0 to b" + std::to_string(width - 1);
        n.mask = n.value = 1u << static_cast<unsigned>(*bit);
    } else {
        const std::optional<std::uint32_t> code = parse_code(place, row);
        if (!code) return csv::shown(place) + " is no code of " + type_text(row.entry, row.table);
        n.value = *code;
    }
    if (std::string why = judge_name(n, row.entry); !why.empty()) return why;
    row.names.push_back(n);
    return {};
}

// A name, or a code, that is there twice. Blanks and _ are the same.
std::string check_twice(std::span<const cell_name> names) {
    std::vector<std::pair<std::string, std::uint64_t>> all;
    for (const cell_name& n : names) {
        std::string folded{n.name};
        std::ranges::replace(folded, ' ', '_');
        all.emplace_back(std::move(folded), std::uint64_t{n.mask} << 32 | n.value);
    }
    const auto twice = [&](auto member) {
        std::ranges::sort(all, {}, member);
        return std::ranges::adjacent_find(all, {}, member);
    };
    if (const auto name = twice(&std::pair<std::string, std::uint64_t>::first); name != all.end())
        return "the name " + csv::shown(name->first) + " is there twice";
    if (const auto code = twice(&std::pair<std::string, std::uint64_t>::second); code != all.end())
        return "a code has two names: " + csv::shown(code->first) + " and " + csv::shown((code + 1)->first);
    return {};
}

} // namespace

std::string parse_names_cell(std::string_view cell, device_row& row) {
    row.entry.names = servobus::naming::number;
    if (cell.empty()) return {};
    const bool is_beyond = is_text(row.entry) || is_float(row.entry) || row.entry.words() > 2;
    if (is_beyond && cell != "hex") return "names are for whole numbers of one or two registers";
    if (is_text(row.entry) || is_float(row.entry)) return "hex is for whole numbers";
    if (cell == "halves" && (row.entry.words() != 1 || !is_plain(row.entry)))
        return "halves are of a whole register, u16 or i16";
    if (is_of_bits(row.table) && (cell == "halves" || cell == "hex"))
        return "a bit has neither halves nor hex";
    row.entry.names = cell == "halves" ? servobus::naming::halves : servobus::naming::names;
    if (cell == "halves" || cell == "hex") return {};
    for (const std::string_view part : csv::parts(cell)) {
        if (std::string why = one_name(part, row); !why.empty()) return why;
    }
    return check_twice(row.names);
}

} // namespace tool
