// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_file.hpp"

#include <algorithm>
#include <set>

#include "../devices/device.hpp"
#include "../os/interrupts.hpp"
#include "../parameters/parameters.hpp"
#include "../registers/typed_value.hpp"
#include "../words/numbers.hpp"
#include "other_drive.hpp"
#include "reading.hpp"

namespace tool::diagnosis {
namespace {

std::string range_text(const servobus::entry& e) {
    return number_text(e, e.limits.low) + " .. " + number_text(e, e.limits.high);
}

void judge_value(report& to, const servobus::entry& e, std::span<const u16> words,
                 const servobus::row_scale& scale, const std::string& command) {
    const std::string name = static_cast<const char*>(e.name);
    const std::string value = name + '=' + words_text(e, words, scale);
    const bool has_default = e.rights == servobus::access::rw && e.initial != servobus::no_default;
    if (!is_text(e) && value_of_words(e, words).is == servobus::row_value::state::no_value) return;
    if (!takes_words(e, words)) {
        const bool is_digit =
            !is_text(e) && value_of_words(e, words).is == servobus::row_value::state::no_number;
        to.warn(value + (is_digit ? "" : ": outside " + range_text(e)), has_default ? command : "");
    } else if (has_default && !std::ranges::equal(words, words_of(e, e.initial))) {
        to.differ_from_default(value, number_text(e, e.initial));
    }
}

// The content of a table's rows.
struct table_content {
    servobus::table in;
    std::vector<const servobus::entry*> rows{};
    held_registers held{};
    std::vector<diagnosis::unread> refused{};
    bool is_whole = false; ///< the device has responded to each request
};

std::vector<const servobus::entry*> readable_rows(const target& of, servobus::table in) {
    std::vector<const servobus::entry*> rows;
    for (const servobus::entry& e : of.kind->rows_of(in)) {
        if (e.rights != servobus::access::wo) rows.push_back(&e);
    }
    return rows;
}

// Sets `ended` to what ended it before the last row.
std::vector<table_content> read_tables(session& on, const target& of, servobus::status& ended) {
    std::vector<table_content> all;
    for (const servobus::table t : all_tables) {
        table_content& now = all.emplace_back(table_content{.in = t, .rows = readable_rows(of, t)});
        const auto read = [&](std::span<const servobus::entry* const> some, std::span<u16> words) {
            if (interrupts::came()) return servobus::status{servobus::errc::bad_argument};
            return on.read(some, words, t);
        };
        for (const diagnosis::unread& u : read_into(now.held, now.rows, of.facts().max_read, read)) {
            if (!is_refusal(u.why)) {
                ended = u.why;
                return all;
            }
            now.refused.push_back(u);
        }
        now.is_whole = true;
    }
    return all;
}

// ` (exception 2)`, ` (exceptions 1, 2)`
std::string exceptions_of(std::span<const table_content> all) {
    std::set<unsigned> numbers;
    for (const table_content& t : all) {
        for (const diagnosis::unread& u : t.refused) {
            if (u.why.error() == servobus::errc::exception) numbers.insert(u.why.exception());
        }
    }
    std::string text;
    for (const unsigned n : numbers) text += (text.empty() ? "" : ", ") + std::to_string(n);
    return text.empty() ? text : (numbers.size() == 1 ? " (exception " : " (exceptions ") + text + ')';
}

// A device that refuses most rows of a file is not the one that the file describes: its other rows mean nothing.
bool judge_whole_file(report& to, session& on, const target& of, std::span<const table_content> all) {
    std::size_t rows = 0, refused = 0;
    for (const table_content& t : all) {
        rows += t.rows.size();
        refused += t.refused.size();
    }
    constexpr std::size_t fewest = 3; // that say something of a device
    if (2 * refused <= rows || rows < fewest) return false;
    const std::string what = std::to_string(refused) + " of " + counted(rows, "row") + " of " +
                             of.kind->word() + (refused == 1 ? " is refused" : " are refused") +
                             exceptions_of(all);
    if (!explain_other_drive(to, on, of, what))
        to.refuse(what + ": the file describes another device", "give the file of the device that is there");
    return true;
}

// The words of a row; none if it was not read.
std::vector<u16> words_held(const table_content& t, const servobus::entry& e) {
    std::vector<u16> words;
    if (!t.is_whole || !t.held.has(e.address)) return words;
    for (std::size_t i = 0; i < e.words(); ++i) words.push_back(t.held.word(static_cast<u16>(e.address + i)));
    return words;
}

servobus::row_scale scale_of(const target& of, const servobus::entry& e, std::span<const table_content> all) {
    const servobus::entry* const by = of.kind->scaling_row(e);
    if (by == nullptr) return {};
    if (all.size() <= static_cast<std::size_t>(e.form->scale_table)) return unknown_scale(e);
    const std::vector<u16> words = words_held(all[static_cast<std::size_t>(e.form->scale_table)], *by);
    return words.empty() ? unknown_scale(e) : scale_from(e, *by, value_of_words(*by, words));
}

} // namespace

servobus::status judge_rows(report& to, session& on, const target& of) {
    servobus::status ended{};
    const std::vector<table_content> all = read_tables(on, of, ended);
    if (ended.error() == servobus::errc::ok && judge_whole_file(to, on, of, all)) return {};
    for (const table_content& t : all) {
        for (const diagnosis::unread& u : t.refused)
            to.unread(std::string{static_cast<const char*>(u.row->name)} + ": " + why_text(of, u.why, on),
                      false);
        for (const servobus::entry* e : t.rows) {
            const std::vector<u16> words = words_held(t, *e);
            if (words.empty()) continue;
            const std::string back = e->initial == servobus::no_default
                                         ? ""
                                         : typed_assignment(choose(*e, t.in), words_of(*e, e->initial));
            judge_value(to, *e, words, scale_of(of, *e, all), to.command("write", back));
        }
    }
    return ended;
}

} // namespace tool::diagnosis
