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

/// A name with letters, digits and `_` alone that is neither a keyword nor a usual macro. `-20` is `minus_20`. `prefix`
/// is in front of a name that would begin with a digit, or as the compiler's own do.
std::string identifier(std::string_view text, std::string_view prefix);
/// A text in quotes.
std::string literal(std::string_view text);

/// The names of a namespace, an enumeration or the like.
class scope {
  public:
    scope(std::string_view prefix, std::span<const std::string_view> taken)
        : prefix_{prefix}, used_{taken.begin(), taken.end()} {}

    /// `text` as a name that has not been there: `int` and `int_` are `int_` and `int__`.
    std::string name(std::string_view text);

  private:
    std::string_view prefix_;
    std::set<std::string> used_;
};

} // namespace tool::cpp
