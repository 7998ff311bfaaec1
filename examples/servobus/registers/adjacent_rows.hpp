// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows that one request reads: adjacent ones, and parts of one register.
#pragma once

#include <cstddef>
#include <span>

#include <servobus/registers/catalogue.hpp>

namespace tool {

using row_list = std::span<const servobus::entry* const>;

/// True if a request that ends with `last` can go on with `next`.
inline bool follows(const servobus::entry& last, const servobus::entry& next) {
    const bool share_register = last.is_part() && next.is_part() && last.address == next.address;
    return share_register || next.address == last.address + last.words();
}

/// The registers, or bits, from the first of these rows to the last.
inline std::size_t words_between(row_list rows) {
    return rows.back()->address + rows.back()->words() - rows.front()->address;
}

/// The number of the first rows that one request of `most` registers or bits reads. The rows are in address order.
inline std::size_t count_adjacent(row_list rows, std::size_t most) {
    std::size_t count = 1;
    while (count < rows.size() && follows(*rows[count - 1], *rows[count]) &&
           words_between(rows.first(count + 1)) <= most)
        ++count;
    return count;
}

} // namespace tool
