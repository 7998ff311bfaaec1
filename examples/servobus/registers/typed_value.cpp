// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "typed_value.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace tool {

std::string typed_value(const chosen& what, std::span<const u16> words) {
    const servobus::entry& row = *what.row;
    const auto gives_words = [&](const std::string& text) {
        std::vector<u16> given;
        return read_value(row, what.form.is_bit(), text, given).empty() && std::ranges::equal(given, words);
    };
    const std::string shown = value_text(what, words);
    const std::string without_unit = shown.substr(0, shown.find(' '));
    if (without_unit.find("0x") == without_unit.npos && gives_words(without_unit)) return without_unit;
    // Bits without a name are in hexadecimal; none of them is 0.
    const std::int64_t count = number_of(row, words);
    const bool is_number = count == 0 || row.names == servobus::naming::number;
    if (std::string whole = std::to_string(count); is_number && gives_words(whole)) return whole;
    std::string content = "0x";
    for (const u16 word : words) {
        char digits[8];
        (void)std::snprintf(digits, sizeof digits, "%04X", static_cast<unsigned>(word));
        content += digits;
    }
    return content;
}

std::string typed_assignment(const chosen& what, std::span<const u16> words) {
    return what.name + '=' + typed_value(what, words);
}

} // namespace tool
