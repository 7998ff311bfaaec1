// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Names and texts of C++ from those of a device, for headers that the tool makes.
#pragma once

#include <set>
#include <span>
#include <string>
#include <string_view>

namespace tool::cpp {

/// A name with letters, digits and `_` alone that is neither a keyword nor a usual macro.
std::string identifier(std::string_view text);
/// A text in quotes.
std::string literal(std::string_view text);

/// The names of a namespace, an enumeration or the like.
class scope {
  public:
    explicit scope(std::span<const std::string_view> taken) : used_{taken.begin(), taken.end()} {}

    /// `text` as a name that has not been there: `int` and `int_` are `int_` and `int__`.
    std::string name(std::string_view text);

  private:
    std::set<std::string> used_;
};

} // namespace tool::cpp
