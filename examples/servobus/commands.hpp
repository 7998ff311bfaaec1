// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands and their options, in one table. The command line is parsed by it; help, man page and
// completion are made from it.
//
// To add a command: its function in tool.hpp, its options in command_options.hpp, its row in commands.cpp.
#pragma once

#include <span>
#include <string_view>

#include "tool.hpp"

namespace tool {

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

std::span<const command> commands();
/// All that any command has.
std::span<const option_group* const> shared_options();
/// Null if there is none.
const command* find_command(std::string_view name);
/// As above, but complains by itself.
const command* require_command(std::string_view name);

/// What a word of the command line stands for.
struct topic {
    std::string_view name;
    std::string_view about; ///< paragraphs, as in `command`
};

/// DEVICE, NODE, PORT, REG, VALUE.
std::span<const topic> topics();

struct example {
    std::string_view line;
    std::string_view what;
};
std::span<const example> examples();

extern const std::string_view purpose;     ///< of the tool, one line
extern const std::string_view exit_status; ///< paragraphs

} // namespace tool
