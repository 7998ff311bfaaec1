// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_file.hpp"

#include "../os/interrupts.hpp"
#include "../parameters.hpp"
#include "../text/typed_value.hpp"
#include "reading.hpp"

namespace tool::diagnosis {
namespace {

std::string range_text(const servobus::entry& e) {
    return number_text(e, e.limits.low) + " .. " + number_text(e, e.limits.high);
}

void judge_value(report& to, const servobus::entry& e, std::int64_t number, const std::string& command) {
    const std::string name = static_cast<const char*>(e.name);
    const std::string value = name + '=' + number_text(e, number);
    if (!e.takes(number)) {
        const bool can_mend = e.rights == servobus::access::rw && e.initial != servobus::no_default;
        to.warn(value + ": outside " + range_text(e), can_mend ? command : "");
    } else if (e.rights == servobus::access::rw && e.initial != servobus::no_default && number != e.initial) {
        to.differ_from_default(value, number_text(e, e.initial));
    }
}

} // namespace

servobus::status judge_rows(report& to, session& on, const target& of) {
    for (const servobus::table t : all_tables) {
        std::vector<const servobus::entry*> rows;
        for (const servobus::entry& e : of.kind->rows_of(t)) {
            if (e.rights != servobus::access::wo) rows.push_back(&e);
        }
        held_registers held;
        const auto read = [&](std::span<const servobus::entry* const> some, std::span<u16> words) {
            if (interrupts::came()) return servobus::status{servobus::errc::bad_argument};
            return on.read(some, words, t);
        };
        for (const diagnosis::unread& u : read_into(held, rows, of.facts().max_read, read)) {
            if (!is_refusal(u.why)) return u.why;
            to.unread(std::string{static_cast<const char*>(u.row->name)} + ": " + why_text(of, u.why, on),
                      false);
        }
        for (const servobus::entry* e : rows) {
            if (!held.has(e->address)) continue;
            std::vector<u16> words;
            for (std::size_t i = 0; i < e->words(); ++i)
                words.push_back(held.word(static_cast<u16>(e->address + i)));
            const std::string back = e->initial == servobus::no_default
                                         ? ""
                                         : typed_assignment(choose(*e, t), words_of(*e, e->initial));
            judge_value(to, *e, number_of(*e, words), to.command("write", back));
        }
    }
    return {};
}

} // namespace tool::diagnosis
