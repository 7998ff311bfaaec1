// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Paragraphs of help and man page on more than one command.
#pragma once

#include <span>
#include <string_view>

namespace tool {

/// A word of the command line, and its meaning.
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
