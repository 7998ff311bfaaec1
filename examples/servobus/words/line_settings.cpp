// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "line_settings.hpp"

namespace tool {

std::optional<servobus::character_format> parse_format(std::string_view text) {
    using enum servobus::character_format;
    for (const auto format : {n81, n82, e81, o81}) {
        if (text == servobus::text(format)) return format;
    }
    return std::nullopt;
}

} // namespace tool
