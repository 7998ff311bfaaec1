// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names of codes and bits from the cell `names` of a row of a device file.
#pragma once

#include <string>
#include <string_view>

#include "device_row.hpp"

namespace tool {

/// Reads the cell into `row`, which has its table, type and range. Returns the reason why the cell is refused; empty if
/// it is not.
std::string parse_names_cell(std::string_view cell, device_row& row);

} // namespace tool
