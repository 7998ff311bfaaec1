// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The command line of a command, taken apart.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"

namespace tool {

/// The words of a command, and its options with or without a value.
class arguments {
  public:
    /// The words after the command's name. Complains by itself, also about an option that `of` does not have.
    static std::optional<arguments> parse(std::span<char* const> words, const command& of);

    /// The command that is asked.
    const command& of() const { return *of_; }
    const std::vector<std::string>& words() const { return words_; }
    bool has(std::string_view name) const { return find(name) != nullptr; }
    const char* text(std::string_view name) const;
    /// The option's number, or `otherwise` if it is not given. Complains by itself.
    std::optional<std::int64_t> number(std::string_view name, std::int64_t low, std::int64_t high,
                                       std::int64_t otherwise) const;
    /// `off` if it is not given. Complains by itself.
    std::optional<bool> on_or_off(std::string_view name) const;

  private:
    explicit arguments(const command& of) : of_{&of} {}

    const std::string* find(std::string_view name) const;

    const command* of_;
    std::vector<std::string> words_{};
    std::map<std::string, std::string, std::less<>> options_{};
};

} // namespace tool
