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
    std::uint32_t mask;
    std::uint32_t value;
    std::string_view name;
};

/// Holds what a row says. `entry.values` is empty: `names` has them. `entry.form` is null or `form`, so a row stays
/// where it was made.
struct device_row {
    device_row() = default;
    device_row(const device_row&) = delete;
    device_row& operator=(const device_row&) = delete;

    servobus::table table = servobus::table::holding_registers;
    servobus::entry entry{};
    std::vector<cell_name> names{};
    bool is_selectable = false; ///< `word_order` is
    servobus::value_form form{};
    std::vector<std::int64_t> none{};
    std::string symbol{};                 ///< of a unit of the device's own
    std::string_view factor_row{};        ///< the name or the address of the row that scales it
    bool is_low_byte_first_usual = false; ///< the file's key `byte_order` is low
};

/// Reads the cells. Returns the reason why the row is refused; empty if it is not.
std::string parse_row(const row_cells& cells, device_row& row);

} // namespace tool
