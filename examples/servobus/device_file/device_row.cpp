// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_row.hpp"

#include <algorithm>
#include <optional>

#include <servobus/registers/row_value.hpp>

#include "../words/csv.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "device_form.hpp"
#include "device_names.hpp"
#include "device_range.hpp"
#include "device_unit.hpp"

namespace tool {
namespace {

using servobus::access;
using servobus::entry;
using servobus::flag;
using servobus::u16;
using servobus::u32;
using servobus::value_kind;

// Reads the cells one by one. Each step that fails gives its reason.
class row_reader {
  public:
    row_reader(const row_cells& cells, device_row& row) : cells_{&cells}, row_{&row} {}

    std::string read() {
        using step = std::string (row_reader::*)();
        constexpr step steps[] = {&row_reader::name,    &row_reader::place, &row_reader::table,
                                  &row_reader::type,    &row_reader::form,  &row_reader::words,
                                  &row_reader::rights,  &row_reader::times, &row_reader::modes,
                                  &row_reader::flags,   &row_reader::unit,  &row_reader::range,
                                  &row_reader::initial, &row_reader::names, &row_reader::order};
        for (const step s : steps) {
            const std::string why = (this->*s)();
            if (why.empty()) continue;
            return s == steps[0] ? why : std::string{static_cast<const char*>(row_->entry.name)} + ": " + why;
        }
        return {};
    }

  private:
    std::string_view cell(map_column column) const { return (*cells_)[static_cast<std::size_t>(column)]; }
    // ` takes this, not 'that'`
    std::string bad(map_column column, std::string_view takes) const {
        return std::string{map_columns[static_cast<std::size_t>(column)]} + " takes " + std::string{takes} +
               ", not " + csv::shown(cell(column));
    }
    bool is_bit() const { return is_of_bits(row_->table); }
    const char* type_name() const { return type_text(row_->entry, row_->table); }
    void add(flag f) { row_->entry.flags = row_->entry.flags | f; }

    std::string name() {
        const std::string_view text = cell(map_column::name);
        if (text.empty()) return "the row has no name";
        const auto is_letter = [](char c) {
            return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
        };
        const auto is_good = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
        if (text.size() > servobus::label::longest)
            return "the name " + csv::shown(text) + " has more than " +
                   std::to_string(servobus::label::longest) + " characters";
        if (!is_letter(text[0]) || !std::ranges::all_of(text, is_good))
            return "the name " + csv::shown(text) +
                   " is no letter or '_' with letters, digits and '_' after it";
        row_->entry.name = servobus::label{std::string{text}.c_str()};
        return {};
    }

    std::string place() {
        const std::string_view text = cell(map_column::address);
        const std::optional<std::int64_t> address = parse_address(text);
        if (!address || *address < 0 || *address > 0xFFFF)
            return bad(map_column::address, "0x0000 to 0xFFFF, 8244 or 2034h") +
                   (address > 0xFFFF
                        ? "; an address is that in the frame, 0x0000 for 40001 or 400001 in a manual"
                        : "");
        row_->entry.address = static_cast<u16>(*address);
        return {};
    }

    std::string table() {
        const std::string_view text = cell(map_column::table);
        if (text.empty()) return {};
        using enum servobus::table;
        for (const servobus::table t : {coils, discrete_inputs, holding_registers, input_registers}) {
            if (text != table_text(t)) continue;
            row_->table = t;
            return {};
        }
        return bad(map_column::table, "coil, discrete, holding or input");
    }

    std::string type() {
        const std::string_view text = cell(map_column::type);
        row_->entry.kind = value_kind::unsigned_word;
        if (text.empty()) return {};
        if (is_bit() != (text == "bool"))
            return "type " + csv::shown(text) + " and table " + table_text(row_->table) +
                   " contradict each other";
        if (is_bit()) return {};
        std::string all;
        for (unsigned i = 0; i <= static_cast<unsigned>(value_kind::text); ++i) {
            const auto kind = static_cast<value_kind>(i);
            all += (kind == value_kind::text ? " or "
                    : all.empty()            ? ""
                                             : ", ") +
                   std::string{servobus::text(kind)};
            if (text != servobus::text(kind) && (kind != value_kind::text || text != "string")) continue;
            row_->entry.kind = kind;
            return {};
        }
        return bad(map_column::type, all) + later_version;
    }

    std::string form() { return parse_form(*cells_, *row_); }

    std::string words() {
        const std::size_t size = row_->entry.words();
        if (row_->entry.address + size > 0x1'0000)
            return (size == 2 ? "its second word" : "its last word") +
                   std::string{" is beyond address 0xFFFF"};
        const std::string_view text = cell(map_column::words);
        if (text.empty() || text == std::to_string(size)) return {};
        return "words is " + csv::shown(text) + ", but " + type_name() + " has " + std::to_string(size);
    }

    std::string rights() {
        const std::string_view text = cell(map_column::access);
        row_->entry.rights = access::ro;
        if (text.empty()) return {};
        for (const access a : {access::ro, access::rw, access::wo}) {
            if (text != servobus::text(a)) continue;
            row_->entry.rights = a;
            const bool is_input = row_->table == servobus::table::discrete_inputs ||
                                  row_->table == servobus::table::input_registers;
            if (!is_input || a == access::ro) return {};
            return "access " + std::string{text} + " and table " + table_text(row_->table) +
                   " contradict each other";
        }
        return bad(map_column::access, "ro, rw or wo");
    }

    std::string times() {
        const std::string_view saved = cell(map_column::saved);
        if (saved == "yes") {
            add(flag::saved);
        } else if (!saved.empty() && saved != "no") {
            return bad(map_column::saved, "yes or no");
        }
        const std::string_view when = cell(map_column::when);
        if (when == "stopped") {
            add(flag::when_stopped);
        } else if (when == "running") {
            add(flag::when_running);
        } else if (!when.empty()) {
            return bad(map_column::when, "stopped, running or nothing");
        }
        const std::string_view effective = cell(map_column::effective);
        if (effective == "immediate") {
            add(flag::immediate);
        } else if (effective == "at_stop") {
            add(flag::at_stop);
        } else if (effective == "power_cycle") {
            add(flag::after_power_cycle);
        } else if (!effective.empty()) {
            return bad(map_column::effective, "immediate, at_stop, power_cycle or nothing");
        }
        return {};
    }

    std::string modes() {
        const std::string_view text = cell(map_column::modes);
        if (text == "ALL") {
            add(flag::every_mode);
            return {};
        }
        for (const char c : text) {
            const flag mode = c == 'P'   ? flag::position_mode
                              : c == 'S' ? flag::speed_mode
                              : c == 'T' ? flag::torque_mode
                                         : flag::none;
            if (mode == flag::none || has(row_->entry.flags, mode))
                return bad(map_column::modes, "ALL, letters of PST or nothing");
            add(mode);
        }
        return {};
    }

    std::string flags() {
        const std::string_view text = cell(map_column::flags);
        if (text.empty()) return {};
        flag given = flag::none;
        for (const std::string_view part : csv::parts(text)) {
            const auto f = std::ranges::find(flag_words, part, &flag_word::word);
            if (f == std::end(flag_words)) {
                std::vector<std::string_view> known;
                std::string all = "; known: ";
                for (const flag_word& w : flag_words) {
                    all += (known.empty() ? "" : ", ") + std::string{w.word};
                    known.push_back(w.word);
                }
                return "unknown flag " + csv::shown(part) + did_you_mean(part, known, all);
            }
            if (has(given, f->of)) return "the flag " + std::string{part} + " is given twice";
            given = given | f->of;
        }
        return contradictions(given);
    }

    std::string contradictions(flag given) {
        entry& e = row_->entry;
        if (e.rights == access::ro) {
            for (const flag f : {flag::saved_on_write, flag::trigger, flag::motion, flag::zero_by_name}) {
                if (!has(given, f)) continue;
                const auto word = std::ranges::find(flag_words, f, &flag_word::of)->word;
                return "access ro and the flag " + std::string{word} + " contradict each other" +
                       (cell(map_column::access).empty() ? " (ro, since the cell access is empty)" : "");
            }
        }
        if (has(given, flag::saved_on_write)) {
            if (cell(map_column::saved) == "no")
                return "saved no and the flag saved_on_write contradict each other";
            // The column has `yes` for either.
            e.flags = static_cast<flag>(static_cast<std::uint16_t>(e.flags) &
                                        ~static_cast<unsigned>(flag::saved) & 0xFFFFu);
        }
        add(given);
        return {};
    }

    std::string unit() {
        servobus::unit& u = row_->entry.unit_of_count;
        const std::string why = parse_unit(cell(map_column::scale), cell(map_column::unit), u, row_->symbol);
        const bool is_given = !why.empty() || u != servobus::unit{};
        if (is_bit() && is_given) return "a bit has neither scale nor unit";
        if (is_text(row_->entry) && is_given) return "a text has neither scale nor unit";
        if (!row_->symbol.empty()) {
            row_->form.symbol = row_->symbol.c_str();
            row_->entry.form = &row_->form;
        }
        return why;
    }

    std::string range() { return parse_range(*cells_, *row_); }
    std::string initial() { return parse_default(*cells_, *row_); }
    std::string names() { return parse_names_cell(cell(map_column::names), *row_); }

    std::string order() {
        const std::string_view text = cell(map_column::word_order);
        if (text.empty()) return {};
        if (!has_word_order(row_->entry)) return "word_order is for numbers of several words";
        using enum servobus::word_order;
        row_->is_selectable = text == word_order_text(unknown);
        if (row_->is_selectable) return {};
        if (text != word_order_text(high_first) && text != word_order_text(low_first))
            return bad(map_column::word_order, "high, low, selectable or nothing");
        row_->entry.own_word_order = text == word_order_text(high_first) ? high_first : low_first;
        return {};
    }

    const row_cells* cells_;
    device_row* row_;
};

} // namespace

std::string parse_row(const row_cells& cells, device_row& row) { return row_reader{cells, row}.read(); }

} // namespace tool
