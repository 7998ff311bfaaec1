// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "cpp_codes.hpp"

#include <algorithm>

#include "../device_file/named_values.hpp"
#include "cpp_names.hpp"

namespace tool::cpp {

namespace {

// The lowest number of 32 bits has no literal of its own.
std::string enumerator_text(const servobus::entry& e, std::uint32_t bits) {
    const std::int64_t number = code_number(e, bits);
    return number == INT32_MIN ? std::to_string(number + 1) + " - 1" : std::to_string(number);
}
bool has_own_order(const servobus::entry& e) { return e.own_word_order != servobus::word_order::unknown; }

} // namespace

bool has_codes(const servobus::entry& e) {
    const bool is_quantity =
        e.unit_of_count != servobus::unit{} || has(e.flags, servobus::flag::scaled_elsewhere);
    const auto is_code = [](const servobus::named_value& v) { return v.is_whole(); };
    return !is_quantity && is_plain(e) && !has_own_order(e) && !e.values.empty() &&
           std::ranges::all_of(e.values, is_code);
}

std::string enumeration(const servobus::entry& e) {
    const std::string bits = std::to_string(16 * e.words());
    std::string lines = std::string{" : std::"} + (e.is_signed() ? "int" : "uint") + bits + "_t {\n";
    scope names{"code_", {}};
    for (const servobus::named_value& v : e.values) {
        const std::string name = names.name(v.name);
        lines += "    " + name + " = " + enumerator_text(e, v.value) + ',';
        std::string text = v.name;
        std::ranges::replace(text, ' ', '_');
        if (text != name) {
            text = v.name;
            std::ranges::replace(text, '\\',
                                 '/'); // at the end of a comment it would take the next line into it
            lines += " ///< " + text;
        }
        lines += '\n';
    }
    return lines + "};\n";
}

} // namespace tool::cpp
