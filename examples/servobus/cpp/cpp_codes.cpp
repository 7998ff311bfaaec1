// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "cpp_codes.hpp"

#include <algorithm>

#include "cpp_names.hpp"

namespace tool::cpp {

bool has_codes(const servobus::entry& e) {
    const bool is_quantity =
        e.unit_of_count != servobus::unit{} || has(e.flags, servobus::flag::scaled_elsewhere);
    const auto is_code = [](const servobus::named_value& v) { return v.mask == 0xFFFF; };
    return !is_quantity && !e.values.empty() && std::ranges::all_of(e.values, is_code);
}

std::string enumeration(const servobus::entry& e) {
    std::string lines = std::string{" : std::"} + (e.is_signed() ? "int16_t" : "uint16_t") + " {\n";
    scope names{"code_", {}};
    for (const servobus::named_value& v : e.values) {
        const std::string name = names.name(v.name);
        lines += "    " + name + " = " + std::to_string(e.number(v.value)) + ',';
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
