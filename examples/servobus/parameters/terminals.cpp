// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Functions of a drive's terminals: no two that exclude each other may have one, or the drive is in alarm as
// soon as the second one is in force. What is to be written is compared with what the drive holds first.
#include "terminals.hpp"

#include <algorithm>

namespace tool {
namespace {

bool has_function(const device& of, const assignment& a) {
    return a.word != 0 && is_exclusive(of, a.address);
}

// The word that each register holds which excludes one of these.
clash read_rivals(session& on, const target& of, std::span<const assignment> wanted,
                  std::vector<assignment>& held) {
    for (const servobus::entry& e : of.kind->map->entries) {
        const bool is_rival = std::any_of(wanted.begin(), wanted.end(), [&](const assignment& a) {
            return has_function(*of.kind, a) && of.kind->excludes(a.address, e.address);
        });
        if (!is_rival) continue;
        u16 word = 0;
        const servobus::status why = on.read(choose(e), std::span<u16>{&word, 1});
        if (why.error() != servobus::errc::ok) return {.address = e.address, .why = why};
        held.push_back({e.address, word});
    }
    return {};
}

} // namespace

bool is_exclusive(const device& of, u16 address) {
    const auto entries = of.map->entries;
    return of.excludes != nullptr &&
           std::any_of(entries.begin(), entries.end(),
                       [&](const servobus::entry& e) { return of.excludes(address, e.address); });
}

clash find_clash(session& on, const target& of, std::span<const assignment> wanted) {
    if (of.kind == nullptr || of.kind->excludes == nullptr) return {};
    std::vector<assignment> held;
    if (const clash c = read_rivals(on, of, wanted, held); c.why.error() != servobus::errc::ok) return c;
    for (const assignment& a : wanted) {
        if (has_function(*of.kind, a)) {
            for (const assignment& h : held) {
                if (h.word == a.word && of.kind->excludes(a.address, h.address))
                    return {.address = a.address, .holder = h.address};
            }
        }
        for (assignment& h : held) {
            if (h.address == a.address) h.word = a.word;
        }
    }
    return {};
}

std::string clash_text(const target& of, const clash& c, const session& on) {
    if (c.holder == 0)
        return of.kind->display_name(c.address) + ": " + why_text(of, c.why, on) + "; nothing was written";
    return "refused, nothing was written: " + of.kind->display_name(c.holder) + " has the function that " +
           of.kind->display_name(c.address) + " is to get; give it another one first, or none";
}

} // namespace tool
