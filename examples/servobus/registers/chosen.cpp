// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Registers as people write them: names or addresses, the names of their codes, and what they hold.
#include <servobus/registers/value_text.hpp>

#include <algorithm>

#include "../device_file/map_text.hpp"
#include "../device_file/named_values.hpp"
#include "../devices/row_words.hpp"
#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "session.hpp"

namespace tool {

using servobus::entry;

std::vector<std::string> names_of(const entry& e) {
    std::vector<std::string> names;
    for (const servobus::named_value& v : e.values) {
        std::string name{v.name};
        std::ranges::replace(name, ' ', '_');
        names.push_back(std::move(name));
    }
    return names;
}

std::string codes_of(const entry& e) {
    const std::vector<std::string> names = names_of(e);
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i)
        all += (i == 0 ? "" : ", ") + code_text(e, e.values[i]) + " " + names[i];
    return all;
}

std::string what_it_takes(const entry& e) { return e.values.empty() ? "" : "; it takes " + codes_of(e); }

chosen choose(const entry& e, servobus::table in) {
    raw_form form{.table = in};
    if (is_of_bits(in)) form.type = raw_type::bit;
    return {std::string{e.name}, e.address, static_cast<u16>(e.words()), &e, form};
}

static chosen choose(const device& of, const entry& e, servobus::table in) {
    chosen what = choose(e, in);
    what.scaled_by = of.scaling_row(e);
    return what;
}

// `input:0x30` is in the table of input registers. Removes the table from `text`.
static servobus::table take_table(std::string_view& text) {
    for (const servobus::table t : all_tables) {
        const std::string before = table_text(t) + std::string{':'};
        if (!text.starts_with(before)) continue;
        text.remove_prefix(before.size());
        return t;
    }
    return servobus::table::holding_registers;
}

std::optional<chosen> parse_register(const target& of, std::string_view text) {
    if (of.kind == nullptr) return parse_raw_register(text);
    for (const servobus::table t : all_tables) {
        for (const entry& e : of.kind->rows_of(t)) {
            if (text == std::string_view{e.name}) return choose(*of.kind, e, t);
        }
    }
    std::string_view place = text;
    const servobus::table in =
        of.kind->tables != nullptr ? take_table(place) : servobus::table::holding_registers;
    std::optional<std::int64_t> address = parse_address(place);
    if (!address && of.kind->number != nullptr) address = of.kind->number(text);
    if (address && *address >= 0 && *address <= 0xFFFF) {
        const servobus::catalogue rows{of.kind->map->device, of.kind->rows_of(in)};
        const entry* e = rows.find(static_cast<u16>(*address));
        if (e != nullptr && e->address == *address && !e->is_part()) return choose(*of.kind, *e, in);
        if (e != nullptr && e->address == *address) {
            complain(usage, std::string{text} + " is a register of several rows: name one, such as " +
                                std::string{e->name});
            return std::nullopt;
        }
        if (e != nullptr) {
            complain(usage, std::string{text} +
                                (e->words() == 2 ? " is the second word of " : " is inside ") +
                                std::string{e->name} + " (" + hex_word(e->address) +
                                "), which is read and written whole");
            return std::nullopt;
        }
    }
    std::vector<std::string_view> names;
    for (const servobus::table t : all_tables) {
        for (const entry& e : of.kind->rows_of(t)) names.emplace_back(static_cast<const char*>(e.name));
    }
    const std::string device_name = of.facts().name;
    complain(
        usage,
        device_name + " has no register '" + std::string{text} + "'" +
            did_you_mean(text, names,
                         "; servobus map " + of.kind->word() + " lists them" +
                             (of.kind->number != nullptr ? ", a parameter number is written P0B-17" : "")));
    return std::nullopt;
}

std::vector<chosen> parse_readable(const target& of, const arguments& asked) {
    std::vector<chosen> all;
    for (std::size_t i = 2; i < asked.words().size(); ++i) {
        const std::optional<chosen> one = parse_register(of, asked.words()[i]);
        if (!one) return {};
        if (one->row != nullptr && one->row->rights == servobus::access::wo) {
            complain(usage, one->name + ": this register is write-only");
            return {};
        }
        all.push_back(*one);
    }
    return all;
}

std::string value_text(const chosen& what, std::span<const u16> words) {
    return value_text(what, words, what.row != nullptr ? unknown_scale(*what.row) : servobus::row_scale{});
}

std::string value_text(const chosen& what, std::span<const u16> words, const servobus::row_scale& scale) {
    const bool is_plain_bit =
        what.form.is_bit() && what.row != nullptr && words[0] <= 1 && is_on_or_off(*what.row, words[0] == 1);
    if (what.row == nullptr || is_plain_bit) return raw_text(what.form, words);
    return what.scaled_by == nullptr
               ? words_text(*what.row, words, scale)
               : words_text(*what.row, words, scale, static_cast<const char*>(what.scaled_by->name));
}

std::string assigned_text(const chosen& what, std::span<const u16> words, const servobus::row_scale& scale) {
    const std::string value = value_text(what, words, scale);
    return what.name + (value == no_value ? ": " : "=") + value;
}

} // namespace tool
