// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's parameters as the drive holds them.
#include "parameters.hpp"

#include "../os/interrupts.hpp"
#include "../registers/adjacent_rows.hpp"
#include "../streams/messages.hpp"

namespace tool {
namespace {

using servobus::entry;
std::size_t words_in(row_list rows) {
    std::size_t count = 0;
    for (const entry* e : rows) count += e->words();
    return count;
}

// Reads adjacent rows and puts what they hold behind `all`.
servobus::status read_some(session& on, row_list rows, std::vector<parameter>& all) {
    std::vector<u16> words(words_in(rows));
    const servobus::status why = on.read(rows, words);
    if (why.error() != servobus::errc::ok) return why;
    std::span<const u16> rest{words};
    for (const entry* e : rows) {
        const auto own = rest.first(e->words());
        all.push_back({e, std::vector<u16>{own.begin(), own.end()}, {}});
        rest = rest.subspan(e->words());
    }
    return {};
}

// One by one, since the drive refused one of them; what it refuses alone has no words.
servobus::status read_each(session& on, const target& of, row_list rows, std::vector<parameter>& all) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const servobus::status why = read_some(on, rows.subspan(i, 1), all);
        if (why.error() == servobus::errc::exception) {
            all.push_back({rows[i], std::nullopt, why_text(of, why, on)});
        } else if (why.error() != servobus::errc::ok) {
            return why;
        }
    }
    return {};
}

} // namespace

std::optional<std::vector<parameter>> read_parameters(session& on, const target& of, row_list rows) {
    std::vector<parameter> all;
    constexpr std::size_t worth_showing = 20;
    std::optional<progress> shown;
    if (rows.size() >= worth_showing) shown.emplace("reading", rows.size());
    while (!rows.empty()) {
        if (interrupts::came()) {
            shown.reset();
            complain(failed, "interrupted while reading; nothing was written");
            return std::nullopt;
        }
        const row_list some = rows.first(count_adjacent(rows, of.facts().max_read));
        servobus::status why = read_some(on, some, all);
        if (why.error() == servobus::errc::exception) why = read_each(on, of, some, all);
        if (why.error() != servobus::errc::ok) {
            shown.reset();
            complain(failed,
                     std::string{some[0]->name} + ": " + why_text(of, why, on) + "; nothing was written");
            return std::nullopt;
        }
        rows = rows.subspan(some.size());
        if (shown) shown->at(all.size());
    }
    return all;
}

} // namespace tool
