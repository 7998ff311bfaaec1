// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register from a row of a device file.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/registers/catalogue.hpp>

#include "map_text.hpp"

namespace tool {

/// The cells of a row by their columns; a column that the file does not have is empty in each row.
using row_cells = std::array<std::string_view, std::size(map_columns)>;

/// A name of a code or of bits. Its text is the file's until the row has been accepted.
struct cell_name {
    std::uint16_t mask;
    std::uint16_t value;
    std::string_view name;
};

/// Holds what a row says. `entry.values` is empty: `names` has them.
struct device_row {
    servobus::table table = servobus::table::holding_registers;
    servobus::entry entry{};
    std::vector<cell_name> names{};
    bool is_selectable = false; ///< `word_order` is
};

/// The range of a row's type, which its own range lies in.
servobus::range range_of_type(const device_row& row);

/// Reads the cells. Returns the reason why the row is refused; empty if it is not.
std::string parse_row(const row_cells& cells, device_row& row);

} // namespace tool
