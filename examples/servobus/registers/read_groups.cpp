// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "read_groups.hpp"

#include <algorithm>
#include <array>

#include <servobus/modbus/bits.hpp>

#include "../device_file/map_text.hpp"

namespace tool {

std::vector<read_group> groups_of(const target& of, std::span<const chosen> wanted) {
    std::vector<read_group> groups;
    std::array<std::vector<const servobus::entry*>, std::size(all_tables)> rows;
    const bool is_grouped = of.kind != nullptr && of.kind->file != nullptr;
    const auto add = [&](const servobus::entry* row, servobus::table in) {
        if (is_grouped) {
            rows[static_cast<std::size_t>(in)].push_back(row);
        } else {
            groups.push_back({in, {row}});
        }
    };
    for (const chosen& what : wanted) {
        if (what.row == nullptr) continue;
        add(what.row, what.form.table);
        if (const servobus::entry* const by = of.kind->scaling_row(*what.row))
            add(by, what.row->form->scale_table);
    }
    for (const servobus::table t : all_tables) {
        std::vector<const servobus::entry*>& all = rows[static_cast<std::size_t>(t)];
        // The rows of a table are in address order.
        std::ranges::sort(all);
        all.erase(std::unique(all.begin(), all.end()), all.end());
        const std::size_t most = is_of_bits(t) ? servobus::modbus::max_read_bits : of.facts().max_read;
        for (row_list rest{all}; !rest.empty();) {
            const std::size_t count = count_adjacent(rest, most);
            groups.push_back({t, {rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count)}});
            rest = rest.subspan(count);
        }
    }
    return groups;
}

} // namespace tool
