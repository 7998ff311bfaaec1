// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Names that a person may have meant by a word that is none of them.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tool {

/// The names nearest to `word`, the nearest first: at most three, and none if none is near. Near is a name
/// that differs by few letters (one for each three of `word`, at most three; two neighbours that are
/// exchanged count as one). If there is none: names that contain `word`, or each of its parts between
/// underscores. Capital letters and `-` for `_` do not count.
std::vector<std::string_view> nearest(std::string_view word, std::span<const std::string_view> names);

/// The end of a complaint about `word`: `; did you mean a, b or c?`, with `before` in front of each name; or
/// `otherwise` if none is near.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> names,
                         std::string_view otherwise, std::string_view before = "");

} // namespace tool
