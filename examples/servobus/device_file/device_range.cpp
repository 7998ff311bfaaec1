// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_range.hpp"

#include <algorithm>
#include <optional>

#include <servobus/registers/row_value.hpp>

#include "../words/csv.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

// The range of a row's type, which its own range lies in.
servobus::range range_of_type(const device_row& row) {
    if (is_of_bits(row.table)) return {0, 1, false};
    const servobus::entry& e = row.entry;
    if (is_text(e) || is_float(e)) return servobus::full<std::int64_t>;
    const unsigned width = width_of(e);
    const auto below = [](unsigned bits) {
        return static_cast<std::int64_t>((std::uint64_t{1} << bits) - 1);
    };
    servobus::range found{0, below(std::min(width, 63u)), false};
    if (is_two_complement(e)) found = {-below(width - 1) - 1, below(width - 1), false};
    if (is_sign_and_magnitude(e)) found = {-below(width - 1), below(width - 1), false};
    if (is_bcd(e)) {
        found.high = 1;
        for (unsigned digit = 0; digit < width / 4; ++digit) found.high *= 10;
        --found.high;
    }
    if (e.form != nullptr) { // of up to 32 bits, where it has an offset
        found.low += e.form->offset;
        found.high += e.form->offset;
    }
    return found;
}

std::string_view cell(const row_cells& cells, map_column column) {
    return cells[static_cast<std::size_t>(column)];
}

// ` takes a whole number of counts, not 'that'`
std::string no_number(const row_cells& cells, map_column column, const servobus::entry& e) {
    return std::string{map_columns[static_cast<std::size_t>(column)]} + " takes a whole number of " +
           (is_float(e) ? "its unit" : "counts") + ", not " + csv::shown(cell(cells, column));
}

std::string range_text(servobus::range r) { return std::to_string(r.low) + " .. " + std::to_string(r.high); }

} // namespace

std::string parse_range(const row_cells& cells, device_row& row) {
    const servobus::range whole = range_of_type(row);
    const std::string_view low = cell(cells, map_column::min), high = cell(cells, map_column::max);
    servobus::entry& e = row.entry;
    e.limits = whole;
    if (low.empty() && high.empty()) return {};
    if (is_text(e)) return "a text has neither min nor max";
    if (low.empty() || high.empty()) return "min and max are given both, or neither";
    const std::optional<std::int64_t> least = parse_integer(low), most = parse_integer(high);
    if (!least) return no_number(cells, map_column::min, e);
    if (!most) return no_number(cells, map_column::max, e);
    if (*least > *most)
        return "the range is upside down: min " + std::to_string(*least) + ", max " + std::to_string(*most);
    const servobus::range given{*least, *most, true};
    if (*least < whole.low || *most > whole.high)
        return "the range " + range_text(given) + " is not inside " + type_text(e, row.table) + ", " +
               range_text(whole);
    e.limits = given;
    return {};
}

std::string parse_default(const row_cells& cells, device_row& row) {
    const std::string_view text = cell(cells, map_column::initial);
    servobus::entry& e = row.entry;
    e.initial = servobus::no_default;
    if (has(e.flags, servobus::flag::zero_by_name) && !e.limits.contains(0))
        return "the flag zero_by_name is there, but 0 is outside the range";
    if (text.empty()) return {};
    if (is_text(e)) return "a text has no default";
    const std::optional<std::int64_t> number = parse_integer(text);
    if (!number) return no_number(cells, map_column::initial, e);
    if (!e.limits.contains(*number))
        return "default " + std::to_string(*number) + " is outside " + range_text(e.limits);
    e.initial = *number;
    return {};
}

} // namespace tool
