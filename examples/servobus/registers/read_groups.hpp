// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The fewest requests that read rows: rows that are adjacent, or parts of one register, are read by one.
#pragma once

#include <span>
#include <vector>

#include "adjacent_rows.hpp"
#include "session.hpp"

namespace tool {

/// Rows of one table that one request reads, in address order.
struct read_group {
    servobus::table in;
    std::vector<const servobus::entry*> rows;
};

/// The requests for these rows and for the rows that scale them. Rows of a drive that the tool knows, and of none, are
/// read one by one, in their order.
std::vector<read_group> groups_of(const target& of, std::span<const chosen> wanted);

} // namespace tool
