// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads the registers of a list of checks, in few requests, by a function that reads rows: that of a session of the
// tool, or of a test. It gets no function that writes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <servobus/core/result.hpp>

#include "../registers/adjacent_rows.hpp"
#include "check.hpp"

namespace tool::diagnosis {

/// A row that the device did not give.
struct unread {
    const servobus::entry* row;
    servobus::status why;
};

/// The device responds, but does not give the register.
inline bool is_refusal(const servobus::status& why) {
    return why.error() == servobus::errc::exception || why.error() == servobus::errc::unexpected_value;
}

/// `read(rows, words)` reads adjacent rows, the high word of each pair first, and returns a status. Rows that are
/// refused together are read one by one. Returns the rows that could not be read; ends at the first that has no
/// response.
template <class Read>
std::vector<unread> read_into(held_registers& held, std::span<const servobus::entry* const> rows,
                              std::size_t most, Read read) {
    std::vector<unread> missing;
    std::vector<u16> words;
    const auto ask = [&](std::span<const servobus::entry* const> some) {
        std::size_t count = 0;
        for (const servobus::entry* e : some) count += e->words();
        words.assign(count, 0);
        const servobus::status why = read(some, std::span<u16>{words});
        if (why.error() != servobus::errc::ok) return why;
        std::size_t at = 0;
        for (const servobus::entry* e : some) {
            // A part has its bits alone; the register holds those of all its parts.
            const bool is_begun = e->is_part() && held.has(e->address);
            const u16 others = is_begun ? held.word(e->address) : u16{0};
            for (std::size_t i = 0; i < e->words(); ++i)
                held.put(static_cast<u16>(e->address + i), static_cast<u16>(words[at++] | others));
        }
        return why;
    };
    while (!rows.empty()) {
        const auto some = rows.first(count_adjacent(rows, most));
        servobus::status why = ask(some);
        if (is_refusal(why)) {
            for (const servobus::entry* const& e : some) {
                why = some.size() == 1 ? why : ask({&e, 1});
                if (why.error() != servobus::errc::ok) missing.push_back({e, why});
                if (why.error() != servobus::errc::ok && !is_refusal(why)) return missing;
            }
        } else if (why.error() != servobus::errc::ok) {
            missing.push_back({some[0], why});
            return missing;
        }
        rows = rows.subspan(some.size());
    }
    return missing;
}

} // namespace tool::diagnosis
