// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The range and the default of a row of a device file, from the cells `min`, `max` and `default`.
#pragma once

#include <string>

#include "device_row.hpp"

namespace tool {

/// Reads `min` and `max` of a row that has its type and form. Returns the reason why they are refused; empty if they
/// are not.
std::string parse_range(const row_cells& cells, device_row& row);
/// Reads `default` of a row that has its range and flags.
std::string parse_default(const row_cells& cells, device_row& row);

} // namespace tool
