// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a probe has found, as a file:
//
//     servobus-findings format=1 device=zlac8015d
//     firmware=107
//     save=marked
//     by_fault=?     # open
//
// It says nothing of its machine and its owner.
#pragma once

#include <string>
#include <string_view>

#include "findings.hpp"

namespace tool {

/// The first lines of such a file, then a line for each interpretation.
std::string findings_head(const findings& found, std::string_view device);
std::string finding_lines(const findings& found);
/// Takes a file apart. Returns what is wrong, `LINE: why`; empty if nothing is.
std::string parse_findings(findings& found, std::string_view device, std::string_view text);

} // namespace tool
