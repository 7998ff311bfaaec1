// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Registers and values as people write them: names or addresses; quantities with the register's scale, exact
// or refused; codes and bits by their names.
#include <servobus/registers/format.hpp>

#include <algorithm>

#include "../device_file/map_text.hpp"
#include "../device_file/named_values.hpp"
#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "session.hpp"

namespace tool {
namespace {

using servobus::entry;
constexpr servobus::word_order high_first = servobus::word_order::high_first; // above the session always

std::string printed(const entry& e, std::int64_t count) {
    char room[64];
    servobus::text_writer text{room};
    servobus::put_quantity(text, e, count);
    return {room, text.size()};
}

bool is_number(std::string_view text) {
    if (text.starts_with('-')) text.remove_prefix(1);
    return !text.empty() && text[0] >= '0' && text[0] <= '9';
}

// One name of a code or bit, blanks written as _.
bool has_name(const servobus::named_value& v, std::string_view name) {
    const std::string_view own = v.name;
    if (own.size() != name.size()) return false;
    for (std::size_t i = 0; i < own.size(); ++i) {
        if ((own[i] == ' ' ? '_' : own[i]) != (name[i] == ' ' ? '_' : name[i])) return false;
    }
    return true;
}

// True if a name of the bit is `on` for 0 or `off` for 1: neither word means the usual then.
bool has_own_on_or_off(const entry& e) {
    return std::ranges::any_of(
        e.values, [](const servobus::named_value& v) { return has_name(v, v.value == 0 ? "on" : "off"); });
}

// A code, or several fields joined by +.
std::optional<std::int64_t> parse_names(const entry& e, std::string_view text) {
    std::uint16_t word = 0;
    std::uint16_t taken = 0;
    while (true) {
        const std::size_t plus = text.find('+');
        const std::string_view name = text.substr(0, plus);
        bool is_known = false;
        for (const servobus::named_value& v : e.values) {
            if (is_known || !has_name(v, name)) continue;
            if ((taken & v.mask) != 0) return std::nullopt;
            taken = static_cast<std::uint16_t>(taken | v.mask);
            word = static_cast<std::uint16_t>(word | v.value);
            is_known = true;
        }
        if (!is_known) return std::nullopt;
        if (plus == text.npos) return e.number(word);
        text.remove_prefix(plus + 1);
    }
}

// The complaint about names of which one is none of the register's.
std::string no_name(const entry& e, std::string_view text) {
    const std::vector<std::string> known = names_of(e);
    const std::string all = codes_of(e);
    const std::string complaint = "'" + std::string{text} + "' is none of ";
    while (true) {
        const std::size_t plus = text.find('+');
        const std::string_view name = text.substr(0, plus);
        if (std::ranges::none_of(e.values, [&](const auto& v) { return has_name(v, name); })) {
            const std::string meant =
                did_you_mean(name, std::vector<std::string_view>{known.begin(), known.end()}, "");
            return meant.empty() ? complaint + all : complaint + "its names" + meant;
        }
        if (plus == text.npos) return complaint + all;
        text.remove_prefix(plus + 1);
    }
}

struct decimal {
    std::int64_t digits = 0;
    unsigned decimals = 0;
};

// At most 12 digits, so that nothing below overflows.
std::optional<decimal> parse_decimal(std::string_view text) {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    decimal d;
    bool has_point = false;
    std::size_t count = 0;
    for (const char c : text) {
        if (c == '.' && !has_point) {
            has_point = true;
            continue;
        }
        if (c < '0' || c > '9' || ++count > 12) return std::nullopt;
        d.digits = d.digits * 10 + (c - '0');
        if (has_point) ++d.decimals;
    }
    if (count == 0) return std::nullopt;
    if (is_negative) d.digits = -d.digits;
    return d;
}

// The raw content of a register, as hex; for a signed one its bits.
std::optional<std::int64_t> parse_content(const entry& e, std::string_view text) {
    const std::optional<std::int64_t> bits = parse_integer(text);
    const std::int64_t most = e.words() == 2 ? 0xFFFF'FFFF : 0xFFFF;
    if (!bits || *bits < 0 || *bits > most) return std::nullopt;
    return e.number(static_cast<u32>(*bits));
}

enum class reading_error { none, no_number, inexact };

// A number in the register's unit as counts.
reading_error parse_quantity(const entry& e, std::string_view text, std::int64_t& count) {
    const std::optional<decimal> d = parse_decimal(text);
    if (!d) return reading_error::no_number;
    const bool is_raw = has(e.flags, servobus::flag::scaled_elsewhere);
    const servobus::unit u = is_raw ? servobus::unit{} : e.unit_of_count;
    std::int64_t divisor = u.numerator;
    for (unsigned i = 0; i < d->decimals; ++i) divisor *= 10;
    const std::int64_t scaled = d->digits * u.denominator;
    if (scaled % divisor != 0) return reading_error::inexact;
    count = scaled / divisor;
    return reading_error::none;
}

} // namespace

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
            if (text == std::string_view{e.name}) return choose(e, t);
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
        if (e != nullptr && e->address == *address) return choose(*e, in);
        if (e != nullptr) {
            complain(usage, std::string{text} + " is the second word of " + std::string{e->name} + " (" +
                                hex_word(e->address) + "), which is read and written whole");
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
    const bool is_plain_bit = what.form.is_bit() && what.row != nullptr && what.row->values.empty();
    if (what.row == nullptr || is_plain_bit) return raw_text(what.form, words);
    char room[512];
    servobus::text_writer text{room};
    const u32 bits = words.size() == 2 ? servobus::join_words(words[0], words[1], high_first) : u32{words[0]};
    servobus::put_value(text, *what.row, bits, servobus::value_format::tokens);
    if (has(what.row->flags, servobus::flag::scaled_elsewhere)) text << servobus::factory_scale_note;
    return {room, text.size()};
}

std::vector<u16> words_of(const entry& row, std::int64_t number) {
    const auto bits = static_cast<u32>(static_cast<std::uint64_t>(number));
    if (row.words() == 1) return {static_cast<u16>(bits & 0xFFFFu)};
    const servobus::word_pair pair = servobus::split_words(bits, high_first);
    return {pair.first, pair.second};
}

std::int64_t number_of(const entry& row, std::span<const u16> words) {
    return row.number(row.words() == 1 ? u32{words[0]}
                                       : servobus::join_words(words[0], words[1], high_first));
}

std::string number_text(const entry& row, std::int64_t number) {
    return value_text(choose(row), words_of(row, number));
}

std::string undocumented_zero(const entry& e) {
    return std::string{e.name} + ": what 0 does is not documented; only \"write PORT raw:NODE " +
           hex_word(e.address) + "=0\" writes it";
}

std::string read_value(const entry& e, bool is_bit, std::string_view text, std::vector<u16>& words) {
    const std::string shown{text};
    const auto refuse = [&](const std::string& why) { return std::string{e.name} + ": " + why; };
    if (e.rights == servobus::access::ro) return refuse("this register is read-only");

    std::int64_t count = 0;
    if (text.starts_with("0x") || text.starts_with("0X")) {
        const std::optional<std::int64_t> content = parse_content(e, text);
        if (!content) return refuse("'" + shown + "' does not fit the register");
        count = *content;
    } else if (const auto word = parse_names(e, text)) { // first, since a name may begin with a digit: 8N1
        count = *word;
    } else if (is_bit && (text == "on" || text == "off") && !has_own_on_or_off(e)) {
        count = text == "on" ? 1 : 0;
    } else if (!e.is_quantity() && !is_number(text)) {
        return refuse(no_name(e, text));
    } else if (e.names == servobus::naming::halves) {
        return refuse("two values in one word: give the content as 0x....");
    } else {
        const reading_error error = parse_quantity(e, text, count);
        if (error == reading_error::no_number)
            return refuse("'" + shown + (is_bit ? "' is neither on nor off" : "' is no number") +
                          what_it_takes(e));
        if (error == reading_error::inexact) {
            if (has(e.flags, servobus::flag::scaled_elsewhere))
                return refuse("another register sets the scale: give whole counts, not '" + shown + "'");
            return refuse("'" + shown + "' is no whole number of counts; one is " + printed(e, 1));
        }
    }
    if (!e.takes(count)) {
        return refuse("'" + shown + "' is outside " + printed(e, e.limits.low) + " .. " +
                      printed(e, e.limits.high) + what_it_takes(e));
    }
    if (count == 0 && has(e.flags, servobus::flag::zero_by_name)) return undocumented_zero(e);
    words = words_of(e, count);
    return {};
}

std::optional<std::vector<u16>> parse_value(const chosen& what, std::string_view text) {
    if (what.row == nullptr) return parse_raw_values(what, text);
    std::vector<u16> words;
    const std::string why = read_value(*what.row, what.form.is_bit(), text, words);
    if (why.empty()) return words;
    complain(usage, why);
    return std::nullopt;
}

} // namespace tool
