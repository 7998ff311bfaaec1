// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table of the commands as text for a terminal, and as a manual page.
#pragma once

#include <string>

#include "../command_line/arguments.hpp"

namespace tool {

/// MAJOR.MINOR.PATCH
std::string version_text();

/// With a capital letter and a full stop.
std::string sentence(std::string_view text);

/// `--baud N`
std::string heading_of(const option& o);

/// The names of the commands that have these options: `read, write and watch`.
std::string users_of(const option_group& group, const command_table& all);

/// All commands; no line is longer than 80 columns.
std::string help(const command_table& all);
/// One command, with what its words and options mean.
std::string help_of(const command& c);

/// The manual page in roff.
std::string manual_page(const command_table& all);
/// `servobus manual`. Returns the exit status.
int print_manual(const command_table& all, const arguments& asked);

} // namespace tool
