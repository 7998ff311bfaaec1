// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "columns.hpp"

#include <cstdio>

#include <servobus/registers/value_text.hpp>

#include "../registers/session.hpp"
#include "../streams/messages.hpp"
#include "../words/utc.hpp"

namespace tool {
namespace {

namespace ch = std::chrono;
using time_point = ch::system_clock::time_point;

std::string unix_ms_text(time_point t) {
    return std::to_string(ch::floor<ch::milliseconds>(t).time_since_epoch().count());
}

std::string plain_cell(std::string_view text) {
    std::string cell;
    for (const char c : text) {
        if (c != ',' && c != '"' && c != '\r' && c != '\n') cell += c;
    }
    return cell;
}

std::string json_string(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return quoted + '"';
}

// A number, or the text of a row in quotes, as JSON has it.
std::string json_value(std::string_view text) {
    const bool is_quoted = text.size() > 1 && text.starts_with('"') && text.ends_with('"');
    return is_quoted ? json_string(text.substr(1, text.size() - 2)) : std::string{text};
}

bool has_foreign_scale(const servobus::entry& e) { return has(e.flags, servobus::flag::scaled_elsewhere); }

// The worth of a count is not known where another register sets it.
servobus::unit unit_of(const servobus::entry& e) {
    return has_foreign_scale(e) ? servobus::unit{servobus::measure::count} : e.unit_of_count;
}
std::string unit_symbol(const servobus::entry& e) {
    return has_foreign_scale(e) ? symbol(servobus::measure::count) : e.unit_symbol();
}

// The number of a row of a form that drives do not have; `nan` if there is none.
std::string form_number(const servobus::entry& e, std::span<const u16> words,
                        const servobus::row_scale& scale) {
    const servobus::row_value v = value_of_words(e, words);
    const bool is_code = e.is_quantity() && is_named_code(e, v.bits);
    if (is_code || !has_number(v, scale) || has_no_value(v, scale)) return "nan";
    char room[100];
    servobus::text_writer text{room};
    put_number(text, e, v, scale);
    return {room, text.size()};
}

std::string name_of_request(const chosen& what) { return what.row != nullptr ? what.name : raw_name(what); }

} // namespace

void columns::add(const chosen& what, std::size_t place) {
    registers_.push_back(name_of_request(what));
    if (what.row == nullptr) {
        for (std::size_t i = 0; i < raw_count(what); ++i)
            columns_.push_back(
                {.name = raw_name(what, i), .form = what.form, .of = place, .word = i * what.form.width()});
        return;
    }
    column c{.name = what.name,
             .unit = what.row->is_quantity() ? unit_symbol(*what.row) : "",
             .row = what.row,
             .of = place};
    if (what.row->names != servobus::naming::halves) {
        columns_.push_back(c);
        return;
    }
    c.name = what.name + "_left";
    c.which = part::left;
    columns_.push_back(c);
    c.name = what.name + "_right";
    c.which = part::right;
    columns_.push_back(c);
}

std::optional<columns> columns::of(std::span<const chosen> wanted) {
    columns all;
    for (std::size_t i = 0; i < wanted.size(); ++i) all.add(wanted[i], i);
    for (std::size_t i = 0; i < all.columns_.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (all.columns_[i].name != all.columns_[j].name) continue;
            complain(usage, all.columns_[i].name + " is given twice; --csv, --json and --log take it once");
            return std::nullopt;
        }
    }
    return all;
}

std::string columns::number_text(const column& c, const reading& r) {
    const std::span<const u16> words = std::span{r.words}.subspan(c.word);
    if (c.row == nullptr) return raw_number(c.form, words);
    const servobus::entry& e = *c.row;
    if (is_text(e)) return words_text(e, words);
    if (!is_plain(e)) return form_number(e, words, r.scale);
    std::int64_t count = 0;
    if (c.which == part::whole) {
        count = number_of(e, words);
        if (e.is_quantity() && e.is_code(count)) return "nan"; // "no sensor" is no temperature
    } else {
        const unsigned byte = (c.which == part::left ? words[0] >> 8 : words[0]) & 0xFFu;
        count = e.is_signed() ? std::int64_t{static_cast<std::int8_t>(byte)} : std::int64_t{byte};
    }
    char room[64];
    servobus::text_writer text{room};
    servobus::put_count(text, count, unit_of(e));
    return {room, text.size()};
}

// The names of a code or of bits: `enable`; 0x0008 if it has none.
std::string columns::name_text(const column& c, const reading& r) {
    const std::string whole = words_text(*c.row, std::span{r.words}.subspan(c.word), r.scale);
    return whole.substr(0, whole.find(' '));
}

std::string columns::csv_header() const {
    std::string line = "time,error,unix_time (ms)";
    for (const column& c : columns_) line += ',' + c.name + (c.unit.empty() ? "" : " (" + c.unit + ')');
    return line + '\n';
}

std::string columns::csv_row(const snapshot& s) const {
    std::string line = utc_text(s.began) + ',';
    const char* between = "";
    for (std::size_t i = 0; i < registers_.size(); ++i) {
        if (s.readings[i].is_read()) continue;
        line += between + plain_cell(registers_[i] + ": " + s.readings[i].why);
        between = "; ";
    }
    line += ',' + unix_ms_text(s.began);
    for (const column& c : columns_) {
        const reading& r = s.readings[c.of];
        line += ',' + (r.is_read() ? plain_cell(number_text(c, r)) : "nan");
    }
    return line + '\n';
}

std::string columns::json_line(const snapshot& s) const {
    std::string line = std::string{json_begin} + utc_text(s.began) +
                       "\",\"unix_ms\":" + unix_ms_text(s.began) + ",\"registers\":{";
    const char* between = "";
    for (const column& c : columns_) {
        const reading& r = s.readings[c.of];
        const std::string number = r.is_read() ? number_text(c, r) : "null";
        const bool is_number = number != "null" && number != "nan"; // as a code of a quantity is
        line += between + json_string(c.name) + ":{\"value\":" + (is_number ? json_value(number) : "null");
        if (!c.unit.empty()) line += ",\"unit\":" + json_string(c.unit);
        const bool is_quantity = c.row == nullptr || c.row->is_quantity();
        if (!is_quantity ||
            (r.is_read() && c.row != nullptr && c.row->names == servobus::naming::names && !is_number))
            line += ",\"text\":" + (r.is_read() ? json_string(name_text(c, r)) : "null");
        line += '}';
        between = ",";
    }
    line += "},\"errors\":{";
    between = "";
    for (std::size_t i = 0; i < registers_.size(); ++i) {
        if (s.readings[i].is_read()) continue;
        line += between + json_string(registers_[i]) + ':' + json_string(s.readings[i].why);
        between = ",";
    }
    return line + "}}\n";
}

} // namespace tool
