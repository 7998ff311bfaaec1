// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <servobus/registers/row_value.hpp>

#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "device_form.hpp"

namespace tool {
namespace {

using servobus::u16;

constexpr std::string_view blanks = " \t";

bool is_empty_line(std::string_view line) { return line.find_first_not_of(blanks) == line.npos; }
// A comment, or a key of the profile before the header line.
bool is_comment(std::string_view line) { return line.starts_with("##"); }
bool is_key(std::string_view line) { return line.starts_with('#') && !is_comment(line); }

} // namespace

std::string read_text_file(const std::string& path, std::size_t most, std::string& why) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status what = fs::status(path, error);
    // Opening a port could change its lines, and reading a terminal would wait for ever.
    if (fs::exists(what) && !fs::is_regular_file(what) && !fs::is_fifo(what)) {
        why = "cannot read " + path + (fs::is_directory(what) ? ": it is a folder" : ": it is no file");
        return {};
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::fopen(path.c_str(), "rb"), std::fclose};
    std::string text;
    char chunk[4096];
    while (file && text.size() <= most) {
        const std::size_t got = std::fread(chunk, 1, sizeof chunk, file.get());
        if (got == 0) break;
        text.append(chunk, got);
    }
    if (!file || std::ferror(file.get()) != 0) {
        why = "cannot read " + path + ": " + std::strerror(errno);
    } else if (text.size() > most) {
        why = path + " has more than " + std::to_string(most) + " bytes";
    }
    return text;
}

std::string device_file::at_line(std::size_t number, const std::string& why) const {
    return std::to_string(std::max<std::size_t>(number, 1)) + ": " + why;
}

const char* device_file::keep(std::string_view text) { return texts_.emplace_back(text).c_str(); }

std::string device_file::parse(std::string_view path, std::string_view text) {
    lines_ = csv::lines{text};
    if (lines_.is_at_end()) return at_line(1, "the file is empty");
    std::string why = take_profile(path);
    if (why.empty()) why = take_header();
    if (why.empty()) why = take_rows();
    if (why.empty()) why = take_factors();
    if (why.empty()) finish();
    return why;
}

// Up to the header line, which `line_` has then.
std::string device_file::take_profile(std::string_view path) {
    bool is_header = false;
    while (!is_header && !lines_.is_at_end()) {
        line_ = lines_.next();
        if (is_key(line_)) {
            line_of_key_.emplace(csv::trimmed(line_.substr(1, line_.find('=') - 1)), lines_.number());
            const std::string why = profile_.take(csv::trimmed(line_.substr(1)));
            if (!why.empty()) return at_line(lines_.number(), why);
        }
        is_header = !is_key(line_) && !is_comment(line_) && !is_empty_line(line_);
    }
    if (!is_header)
        return at_line(lines_.number(), "the file ends before a header line, such as address,name");
    std::string key;
    const std::string why = profile_.finish(path, key);
    const auto at = line_of_key_.find(key);
    return why.empty() ? why : at_line(at != line_of_key_.end() ? at->second : lines_.number(), why);
}

std::string device_file::take_header() {
    const auto refuse = [&](const std::string& why) { return at_line(lines_.number(), why); };
    if (const std::string why = csv::split(line_, cells_); !why.empty()) return refuse(why);
    place_of_.fill(absent);
    const std::string_view separator = line_.find(';') != line_.npos && cells_.size() == 1
                                           ? "; cells are separated by commas"
                                           : "; the header line names the columns";
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        const auto column = std::ranges::find(map_columns, std::string_view{cells_[i]});
        if (column == std::end(map_columns)) {
            return refuse("unknown column " + csv::shown(cells_[i]) +
                          did_you_mean(cells_[i], map_columns, separator) + later_version);
        }
        std::size_t& place = place_of_[static_cast<std::size_t>(column - std::begin(map_columns))];
        if (place != absent) return refuse("the column " + cells_[i] + " is there twice");
        place = i;
    }
    columns_ = cells_.size();
    for (const map_column needed : {map_column::address, map_column::name}) {
        if (!has_column(needed))
            return refuse("the column " + std::string{map_columns[static_cast<std::size_t>(needed)]} +
                          " is missing");
    }
    return {};
}

std::string device_file::take_rows() {
    while (!lines_.is_at_end()) {
        line_ = lines_.next();
        if (is_comment(line_) || is_empty_line(line_)) continue;
        std::string why = is_key(line_) ? "a line '# key = value' stands before the header line" : take_row();
        if (!why.empty()) return at_line(lines_.number(), why);
    }
    return line_of_name_.empty() ? at_line(lines_.number(), "there is no row after the header line")
                                 : std::string{};
}

std::string device_file::take_row() {
    if (std::string why = csv::split(line_, cells_); !why.empty()) return why;
    if (std::ranges::all_of(cells_, &std::string::empty)) return {}; // as spreadsheets write empty rows
    if (cells_.size() != columns_) {
        return "the row has " + std::to_string(cells_.size()) + (cells_.size() == 1 ? " cell" : " cells") +
               ", the header line " + std::to_string(columns_);
    }
    row_cells cells{};
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (place_of_[i] != absent) cells[i] = cells_[place_of_[i]];
    }
    device_row row;
    row.is_low_byte_first_usual = profile_.is_low_byte_first();
    if (std::string why = parse_row(cells, row); !why.empty()) return why;
    return add(row, cells[static_cast<std::size_t>(map_column::description)]);
}

std::string device_file::add(const device_row& row, std::string_view sentence) {
    const std::string name{static_cast<const char*>(row.entry.name)};
    if (row.is_selectable && profile_.facts().word_order_register == 0) {
        return name +
               ": word_order is selectable, but no line '# word_order_register = ADDRESS' stands before "
               "the header line";
    }
    const auto [first, is_new] = line_of_name_.emplace(name, lines_.number());
    if (!is_new)
        return "the name " + name + " is there twice, first in line " + std::to_string(first->second);
    if (std::string why = take_addresses(row.entry, row.table); !why.empty()) return name + ": " + why;
    found_row found{row.entry, has_column(map_column::description) ? keep(sentence) : nullptr};
    found.in = row.table;
    found.line = lines_.number();
    found.factor_row = row.factor_row;
    found.entry.form = found.form = keep_form(row);
    if (!row.names.empty()) {
        std::vector<servobus::named_value>& all = values_.emplace_back();
        for (const cell_name& n : row.names) all.push_back({n.mask, n.value, keep(n.name)});
        found.entry.values = all;
    }
    found_[static_cast<std::size_t>(row.table)].rows.push_back(found);
    return {};
}

// Null for a row without any.
servobus::value_form* device_file::keep_form(const device_row& row) {
    if (row.entry.form == nullptr) return nullptr;
    servobus::value_form& kept = forms_.emplace_back(row.form);
    if (!row.none.empty()) kept.none = none_.emplace_back(row.none);
    if (!row.symbol.empty()) kept.symbol = keep(row.symbol);
    return &kept;
}

// Rows that scale others may stand behind these.
std::string device_file::take_factors() {
    std::map<std::string_view, const found_row*> by_name;
    std::map<std::pair<servobus::table, std::int64_t>, const found_row*> by_address;
    std::vector<found_row*> scaled;
    for (found_table& t : found_) {
        for (found_row& r : t.rows) {
            by_name.emplace(static_cast<const char*>(r.entry.name), &r);
            by_address.emplace(std::pair{r.in, r.entry.address}, &r);
            if (!r.factor_row.empty()) scaled.push_back(&r);
        }
    }
    std::ranges::sort(scaled, {}, &found_row::line);
    for (const found_row* const r : scaled) {
        const std::optional<std::int64_t> address = parse_address(r->factor_row);
        const auto name = by_name.find(r->factor_row);
        const auto place = by_address.find({r->in, address.value_or(-1)});
        const found_row* const by = name != by_name.end()       ? name->second
                                    : place != by_address.end() ? place->second
                                                                : nullptr;
        const servobus::entry* const row = by != nullptr ? &by->entry : nullptr;
        const auto in = by != nullptr ? by->in : r->in;
        if (const std::string why = judge_factor(r->entry, row, in, r->factor_row); !why.empty())
            return at_line(r->line, static_cast<const char*>(r->entry.name) + (": " + why));
        r->form->scale_table = in;
        r->form->scale_address = row->address;
    }
    return {};
}

// Parts of a register share its address, and no bit.
std::string device_file::take_bits(const servobus::entry& e, servobus::table in) {
    std::vector<taken_bits>& parts = parts_[{in, e.address}];
    for (const taken_bits& other : parts) {
        if ((other.mask & e.form->mask()) != 0)
            return "a bit of it is taken by the row in line " + std::to_string(other.line);
    }
    parts.push_back({e.form->mask(), lines_.number()});
    return {};
}

std::string device_file::take_addresses(const servobus::entry& e, servobus::table in) {
    std::vector<std::uint32_t>& lines = found_[static_cast<std::size_t>(in)].line_of_address;
    if (lines.empty()) lines.assign(0x1'0000, 0);
    const bool has_parts = parts_.contains({in, e.address});
    if (e.is_part() && (has_parts || lines[e.address] == 0)) {
        lines[e.address] = static_cast<std::uint32_t>(lines_.number());
        return take_bits(e, in);
    }
    for (std::size_t i = 0; i < e.words(); ++i) {
        std::uint32_t& line = lines[e.address + i];
        const std::string shown = hex_word(static_cast<u16>(e.address + i));
        if (line != 0) {
            const std::size_t at = e.address + i;
            const bool is_pair =
                (at != 0 && lines[at - 1] == line) || (at + 1 != lines.size() && lines[at + 1] == line);
            return "the address " + shown + " is taken by the " + (is_pair ? "pair" : "row") + " in line " +
                   std::to_string(line);
        }
        line = static_cast<std::uint32_t>(lines_.number());
    }
    return {};
}

void device_file::finish() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
        found_table& t = found_[i];
        std::ranges::sort(t.rows, {}, [](const found_row& r) {
            return std::pair{r.entry.address, r.form != nullptr ? r.form->first_bit : std::uint8_t{0}};
        });
        for (const found_row& r : t.rows) {
            t.entries.push_back(r.entry);
            if (r.sentence != nullptr) t.descriptions.push_back({r.entry.address, r.sentence});
        }
        tables_[i] = {&profile_.facts(), t.entries, t.descriptions};
        // Only the parser needs these.
        t.rows = {};
        t.line_of_address = {};
    }
    line_of_name_.clear();
    parts_.clear();
    cells_.clear();
    line_ = {};
    lines_ = csv::lines{{}};
}

} // namespace tool
