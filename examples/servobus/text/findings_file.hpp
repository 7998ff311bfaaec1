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

#include "../probe/findings.hpp"

namespace tool {

std::string findings_text(const findings& found, std::string_view device);
/// Takes a file apart. Returns what is wrong, `LINE: why`; empty if nothing is.
std::string parse_findings(findings& found, std::string_view device, std::string_view text);

} // namespace tool
