// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace tool {

/// ISO 8601 in UTC with milliseconds: 2026-01-02T03:04:05.678Z
inline std::string utc_text(std::chrono::system_clock::time_point t) {
    namespace ch = std::chrono;
    const auto ms = ch::floor<ch::milliseconds>(t);
    const auto day = ch::floor<ch::days>(ms);
    const ch::year_month_day date{day};
    const ch::hh_mm_ss clock{ms - day};
    char text[96];
    (void)std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", int{date.year()},
                        unsigned{date.month()}, unsigned{date.day()}, static_cast<int>(clock.hours().count()),
                        static_cast<int>(clock.minutes().count()), static_cast<int>(clock.seconds().count()),
                        static_cast<int>(clock.subseconds().count()));
    return text;
}

} // namespace tool
