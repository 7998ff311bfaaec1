// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command as a row of a table: its words and its options. The command line is parsed by it; help, man page and
// completion are made from it.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace tool {

class arguments;

/// `--name`, or `--name VALUE`.
struct option {
    std::string_view name;
    std::string_view value; ///< the placeholder of its value; empty if it takes none
    std::string_view help;
    /// The values that completion offers, with blanks between them. A `LIST` takes several, with commas.
    std::string_view choices{};

    constexpr bool takes_value() const { return !value.empty(); }
};

/// Options that several commands share.
struct option_group {
    std::string_view title;
    std::string_view note;
    std::span<const option> options;
};

struct command {
    std::string_view name;
    /// Its words, in their order: topics such as `PORT`, with `...` if it may be repeated and in brackets if
    /// it may be left out; a word in lower case stands for itself.
    std::string_view words;
    std::string_view summary;          ///< one line
    std::string_view about;            ///< paragraphs, with an empty line between them
    std::span<const option> options{}; ///< of this command alone
    std::span<const option_group* const> shared{};
    int (*run)(const arguments&) = nullptr;
    bool takes_raw = false; ///< DEVICE may be `raw`

    /// Null if it has no such option.
    const option* find(std::string_view option_name) const;
    std::vector<std::string_view> option_names() const;
};

/// All commands.
struct command_table {
    std::span<const command> all;
    /// All that any command has.
    std::span<const option_group* const> shared;

    /// Null if there is none.
    const command* find(std::string_view name) const;
    /// As above, but complains by itself.
    const command* require(std::string_view name) const;
};

} // namespace tool
