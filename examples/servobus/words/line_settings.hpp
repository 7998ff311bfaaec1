// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rates and character formats as people write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <servobus/registers/profile.hpp>

namespace tool {

/// Of a rate in bits a second, on the command line and in files.
inline constexpr std::int64_t lowest_baud = 600;
inline constexpr std::int64_t highest_baud = 4'000'000;

/// Ends a complaint about a format.
inline constexpr const char* formats_taken = "8N1, 8N2, 8E1 or 8O1";
/// One of `formats_taken`.
std::optional<servobus::character_format> parse_format(std::string_view text);

} // namespace tool
