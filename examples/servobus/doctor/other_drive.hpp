// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The drive that responds in place of the one that the command line names, as far as its registers show it.
#pragma once

#include "report.hpp"

namespace tool::diagnosis {

/// Reads what distinguishes the known drives, once the device has refused a register of `of`. If it is another one,
/// reports that and returns true. `what`: what it has refused, and how.
bool explain_other_drive(report& to, session& on, const target& of, const std::string& what);

} // namespace tool::diagnosis
