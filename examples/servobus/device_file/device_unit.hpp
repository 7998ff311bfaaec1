// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What one count of a register is worth, from the cells `scale` and `unit` of a row of a device file.
#pragma once

#include <string>
#include <string_view>

#include <servobus/registers/unit.hpp>

namespace tool {

/// Reads both cells, which may be empty. Sets `own_symbol` if the unit is none of the list. Returns the reason why they
/// are refused; empty if they are not.
std::string parse_unit(std::string_view scale, std::string_view symbol, servobus::unit& of_count,
                       std::string& own_symbol);

} // namespace tool
