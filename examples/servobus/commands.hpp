// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table of the commands.
//
// To add a command: its function in commands/commands.hpp, its options in command_options.hpp, its row in commands.cpp.
#pragma once

#include "command_line/command.hpp"

namespace tool {

const command_table& commands();

} // namespace tool
