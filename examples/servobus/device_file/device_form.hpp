// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The form of a value besides type, scale and unit, from a row of a device file: the cells `bits`, `offset`, `none`,
// `factor` and `byte_order`, and the `words` of a text.
#pragma once

#include <string>
#include <string_view>

#include "device_row.hpp"

namespace tool {

/// Reads the cells into `row`, which has its name, table and type. Returns the reason why a cell is refused; empty if
/// none is.
std::string parse_form(const row_cells& cells, device_row& row);

/// Reads `10^power_exponent` or `ct_ratio`, the name of a row or an address in the table of `row`. Whether there is
/// such a row is known at the end of the file.
std::string parse_factor(std::string_view cell, device_row& row);

/// Why a row cannot scale another one; empty if it can. `by` is null if the file has no such row.
std::string judge_factor(const servobus::entry& e, const servobus::entry* by, servobus::table in,
                         std::string_view wanted);

} // namespace tool
