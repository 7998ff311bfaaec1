// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Completion of command lines. The shell's script asks the tool for the candidates, so that they are those of
// its own tables.
#pragma once

#include <span>
#include <string_view>

#include "../command_line/command.hpp"

namespace tool {

/// The script calls the tool with this word and those of the command line up to the cursor. It is no command
/// for people.
inline constexpr std::string_view completion_word = "__complete";

/// Prints how the shell completes the last of `words`, a command line of one of `all`, then a candidate a line:
/// `words`; `open`, if no blank follows what is completed; `files`, if there are no candidates and file names are
/// wanted. A candidate is what takes the place of the last word. Where the shell breaks words at `:` and `=`, these are
/// words of their own. Never complains.
int print_candidates(const command_table& all, std::span<char* const> words);

} // namespace tool
