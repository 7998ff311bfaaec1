// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges a refusal for the fuzzing targets of the tool's files: it is `LINE: why`, of a line that the file has, in
// plain text.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>
#include <system_error>

#include "support.hpp"

namespace fuzz {

inline void judge_refusal(std::string_view why, std::string_view text) {
    std::size_t line = 0;
    const auto [end, error] = std::from_chars(why.data(), why.data() + why.size(), line);
    require(error == std::errc{} && std::string_view{end, why.data() + why.size()}.substr(0, 2) == ": ",
            "a refusal begins with a line");
    const auto ends = static_cast<std::size_t>(std::ranges::count(text, '\n'));
    require(line >= 1 && line <= ends + 1, "the line is one of the file");
    require(why.size() < 1000, "a refusal is short");
    require(std::ranges::all_of(why, [](char c) { return c >= ' ' && c <= '~'; }), "a refusal is plain text");
}

} // namespace fuzz
