// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "device_form.hpp"

#include <optional>

#include <servobus/registers/row_value.hpp>

#include "../words/csv.hpp"
#include "../words/numbers.hpp"

namespace tool {
namespace {

using servobus::entry;

constexpr std::int64_t most_words = 123;          // of one write
constexpr std::int64_t most_offset = 0x7FFE'0000; // of the library

// Reads the cells one by one. Each step that fails gives its reason.
class form_reader {
  public:
    form_reader(const row_cells& cells, device_row& row) : cells_{&cells}, row_{&row} {}

    std::string read() {
        using step = std::string (form_reader::*)();
        constexpr step steps[] = {&form_reader::words_of_text, &form_reader::bits, &form_reader::offset,
                                  &form_reader::byte_order,    &form_reader::none, &form_reader::factor};
        for (const step s : steps) {
            if (std::string why = (this->*s)(); !why.empty()) return why;
        }
        return {};
    }

  private:
    std::string_view cell(map_column column) const { return (*cells_)[static_cast<std::size_t>(column)]; }
    std::string bad(map_column column, std::string_view takes) const {
        return std::string{map_columns[static_cast<std::size_t>(column)]} + " takes " + std::string{takes} +
               ", not " + csv::shown(cell(column));
    }
    const entry& e() const { return row_->entry; }
    std::string type() const { return type_text(e(), row_->table); }
    std::string no_column(map_column column) const {
        return type() + " has no " + std::string{map_columns[static_cast<std::size_t>(column)]};
    }
    bool is_bit() const { return is_of_bits(row_->table); }
    // From here on the row has a form.
    servobus::value_form& form() {
        row_->entry.form = &row_->form;
        return row_->form;
    }

    std::string words_of_text() {
        if (!is_text(e())) return {};
        const std::optional<std::int64_t> n = parse_integer(cell(map_column::words));
        if (cell(map_column::words).empty()) return "a text needs its length, in the column words";
        if (!n || *n < 1 || *n > most_words)
            return bad(map_column::words, "the registers of a text, 1 to " + std::to_string(most_words));
        form().words = static_cast<std::uint8_t>(*n);
        return {};
    }

    std::string bits() {
        const std::string_view text = cell(map_column::bits);
        if (text.empty()) return {};
        const bool has_bits = !is_bit() && e().words() == 1 && !is_text(e());
        if (!has_bits) return no_column(map_column::bits) + ": bits are of one register";
        const std::size_t dots = text.find("..");
        const auto first = text == "low" ? 0 : text == "high" ? 8 : parse_integer(text.substr(0, dots));
        const auto last = text == "low"       ? 7
                          : text == "high"    ? 15
                          : dots == text.npos ? first
                                              : parse_integer(text.substr(dots + 2));
        if (!first || !last || *first < 0 || *last > 15 || *first > *last)
            return bad(map_column::bits, "7, 0..3, high or low, of bits 0 to 15");
        const auto size = static_cast<std::uint8_t>(*last - *first + 1);
        if (is_bcd(e()) && size % 4 != 0) return bad(map_column::bits, "four bits a digit for bcd16");
        if (is_sign_and_magnitude(e()) && size == 1)
            return bad(map_column::bits, "a sign and a bit for sm16");
        form().first_bit = static_cast<std::uint8_t>(*first);
        form().bits = size;
        return {};
    }

    std::string offset() {
        const std::string_view text = cell(map_column::offset);
        if (text.empty()) return {};
        if (is_bit() || is_text(e()) || is_float(e())) return no_column(map_column::offset);
        const std::optional<std::int64_t> n = parse_integer(text);
        if (e().words() > 2) return no_column(map_column::offset);
        if (!n || *n < -most_offset || *n > most_offset)
            return bad(map_column::offset, "a whole number of counts up to " + std::to_string(most_offset));
        if (*n != 0) form().offset = static_cast<std::int32_t>(*n);
        return {};
    }

    std::string byte_order() {
        const std::string_view text = cell(map_column::byte_order);
        if (!text.empty() && is_bit()) return no_column(map_column::byte_order);
        if (!text.empty() && text != "low" && text != "high")
            return bad(map_column::byte_order, "low, high or nothing");
        if (e().is_part() && text == "low")
            return "byte_order low is for whole registers: bits are counted in the word as it comes";
        const bool may_be_low = !is_bit() && !e().is_part() &&
                                e().kind != servobus::value_kind::unsigned_word &&
                                e().kind != servobus::value_kind::signed_word;
        if (text == "low" || (text.empty() && row_->is_low_byte_first_usual && may_be_low))
            form().is_low_byte_first = true;
        return {};
    }

    // The number that the row's type has for raw bits, as `map` writes it.
    static std::int64_t usual_number(const entry& e, std::uint64_t bits) {
        const std::uint64_t sign = std::uint64_t{1} << (width_of(e) - 1);
        const bool is_negative = is_two_complement(e) && (bits & sign) != 0;
        return static_cast<std::int64_t>(is_negative ? bits | ~all_bits_of(e) : bits);
    }

    std::string none() {
        const std::string_view text = cell(map_column::none);
        if (text.empty()) return {};
        if (is_bit() || is_text(e())) return no_column(map_column::none);
        const std::uint64_t all = all_bits_of(e());
        for (const std::string_view part : csv::parts(text)) {
            const std::optional<std::uint64_t> raw = parse_raw(part);
            // A negative number has ones above the bits of the row.
            const bool is_negative = part.starts_with('-');
            const bool fits = raw && (is_negative ? (*raw & ~(all >> 1)) == ~(all >> 1) : (*raw & ~all) == 0);
            if (!fits) return bad(map_column::none, "raw values of " + type() + ", such as 0x8000;0xFFFF");
            row_->none.push_back(usual_number(e(), *raw & all));
        }
        (void)form();
        return {};
    }

    // 64 bits, of a negative number its two's complement.
    static std::optional<std::uint64_t> parse_raw(std::string_view text) {
        const bool is_negative = text.starts_with('-');
        const std::optional<std::uint64_t> size = parse_magnitude(text.substr(is_negative ? 1 : 0));
        if (!size || (is_negative && *size > std::uint64_t{1} << 63)) return std::nullopt;
        return is_negative ? 0 - *size : *size;
    }

    std::string factor() {
        const std::string_view text = cell(map_column::factor);
        if (text.empty()) return {};
        if (is_bit() || is_text(e())) return no_column(map_column::factor);
        if (is_float(e())) return no_column(map_column::factor) + ": a program scales it";
        if (std::string why = parse_factor(text, *row_); !why.empty()) return why;
        (void)form();
        return {};
    }

    const row_cells* cells_;
    device_row* row_;
};

} // namespace

std::string parse_form(const row_cells& cells, device_row& row) { return form_reader{cells, row}.read(); }

std::string parse_factor(std::string_view cell, device_row& row) {
    constexpr std::string_view exponent = "10^";
    const bool is_exponent = cell.starts_with(exponent);
    const std::string_view by = cell.substr(is_exponent ? exponent.size() : 0);
    if (by.empty())
        return "factor takes 10^ROW of an exponent, or the ROW of a factor, not " + csv::shown(cell);
    row.form.scaled = is_exponent ? servobus::scaling::exponent : servobus::scaling::factor;
    row.factor_row = by;
    return {};
}

std::string judge_factor(const entry& e, const entry* by, servobus::table in, std::string_view wanted) {
    const std::string row = "factor names " + csv::shown(wanted);
    if (by == nullptr) return row + ", but the file has no such row";
    if (by == &e || std::string_view{by->name} == std::string_view{e.name}) return row + ", the row itself";
    if (by->form != nullptr && by->form->scaled != servobus::scaling::none)
        return row + ", which another row scales itself";
    if (is_of_bits(in) || is_text(*by) || is_float(*by) || by->words() > 2 || by->is_part())
        return row + ", which is no whole number of one or two registers";
    if (by->rights == servobus::access::wo) return row + ", which cannot be read";
    return {};
}

} // namespace tool
