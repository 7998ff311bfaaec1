// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "typed_value.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace tool {

namespace {

// All bits of a row, in hexadecimal.
std::string raw_content(const servobus::entry& row, std::span<const u16> words) {
    char digits[24];
    (void)std::snprintf(digits, sizeof digits, "0x%0*llX", static_cast<int>((width_of(row) + 3) / 4),
                        static_cast<unsigned long long>(bits_of_words(row, words)));
    return digits;
}

// In quotes for a shell, since a text has quotes of its own.
std::string typed_whole(const servobus::entry& row, std::span<const u16> words) {
    if (is_text(row)) {
        std::string quoted = "'";
        for (const char c : plain_text(row, words)) quoted += c == '\'' ? "'\\''" : std::string{c};
        return quoted + '\'';
    }
    const servobus::row_value v = value_of_words(row, words);
    const std::string shown = words_text(row, words);
    return v.is == servobus::row_value::state::real ? shown.substr(0, shown.find(' '))
                                                    : raw_content(row, words);
}

} // namespace

std::string typed_value(const chosen& what, std::span<const u16> words) {
    const servobus::entry& row = *what.row;
    const auto gives_words = [&](const std::string& text) {
        std::vector<u16> given;
        return read_value(row, what.form.is_bit(), text, given).empty() && std::ranges::equal(given, words);
    };
    if (is_text(row) || is_float(row)) return typed_whole(row, words);
    const std::string shown = value_text(what, words);
    const std::string without_unit = shown.substr(0, shown.find(' '));
    if (without_unit.find("0x") == without_unit.npos && gives_words(without_unit)) return without_unit;
    // Bits without a name are in hexadecimal; none of them is 0.
    const bool is_number = value_of_words(row, words).bits == 0 || row.names == servobus::naming::number;
    if (std::string whole = plain_text(row, words); is_number && gives_words(whole)) return whole;
    return raw_content(row, words);
}

std::string typed_assignment(const chosen& what, std::span<const u16> words) {
    return what.name + '=' + typed_value(what, words);
}

} // namespace tool
