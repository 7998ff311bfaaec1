// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Registers of a frame as text: their names from the catalogue, their values with scale and unit, and what does not fit
// the register.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/text.hpp>
#include <servobus/explain/table_catalogues.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/reg.hpp>
#include <servobus/registers/value_text.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus::detail {

/// Writes " (0x2080)".
constexpr void put_address(text_writer& out, u16 address) {
    out << " (";
    out.hex_word(address) << ')';
}

/// Writes " (outside 1..5000 ms)" if the row does not take the bits.
constexpr void put_outside(text_writer& out, const entry& e, std::uint64_t bits) {
    const row_value v = value_of(e, bits);
    const bool has_words = v.is == row_value::state::no_value || v.is == row_value::state::no_number;
    if (has_words || takes(e, v)) return;
    out << " (outside ";
    put_count(out, e.limits.low, e.unit_of_count);
    out << "..";
    put_count(out, e.limits.high, e.unit_of_count);
    out << ')';
}

class register_text {
  public:
    enum class kind : std::uint8_t { request, response, values };

    constexpr register_text(const table_catalogues& maps, word_order order, text_writer& out)
        : maps_{maps}, map_{maps.holding_registers},
          word_order_{order == word_order::unknown ? device().word_order : order}, out_{out} {
        if (word_order_ == word_order::unknown) assume_factory_word_order();
    }
    register_text(const register_text&) = delete;
    register_text& operator=(const register_text&) = delete;

    constexpr const profile& device() const { return *maps_.holding_registers->device; }

    /// Writes the names of registers and, if `words` is not empty, their values: "name (0x2080) = 500 ms, …".
    constexpr void put(u16 address, u16 quantity, words_view words, kind how,
                       table in = table::holding_registers) {
        const bool has_own_names = in == table::input_registers && maps_.input_registers != nullptr;
        map_ = has_own_names ? maps_.input_registers : maps_.holding_registers;
        first_ = address;
        in_ = has_own_names || in == table::holding_registers ? in : table::holding_registers;
        bool is_rescalable = false;
        bool is_reorderable = false;
        for (u16 i = 0; i < quantity;) {
            if (i != 0) out_ << ", ";
            const auto at = static_cast<u16>(address + i);
            const entry* e = map_->find(at);
            if (e == nullptr) {
                i = static_cast<u16>(i + unknown(at, static_cast<u16>(quantity - i), words, i));
                continue;
            }
            const std::size_t size = e->words();
            const bool is_whole = at == e->address && i + size <= quantity;
            if (!is_whole) out_ << piece_of(*e, at == e->address);
            put_row_text(*e, at, words, is_whole, how);
            while (has_next_part(e)) {
                out_ << ", ";
                put_row_text(*++e, at, words, is_whole, how);
            }
            is_reorderable = is_reorderable || (i < words.size() && is_whole && is_factory_word_order_ &&
                                                has_word_order(*e) && !has_own_order(*e));
            is_rescalable = is_rescalable || (i < words.size() && has(e->flags, flag::scaled_elsewhere));
            i = static_cast<u16>(i + (is_whole ? size : 1u));
        }
        if (is_reorderable) out_ << " (in the factory's word order)";
        if (is_rescalable) out_ << factory_scale_note;
    }

  private:
    constexpr void assume_factory_word_order() {
        const u16 at = device().word_order_register;
        const entry* e = at != 0 ? map_->find(at) : nullptr;
        if (e == nullptr || e->initial < 0 || e->initial > 1) return;
        word_order_ = e->initial == 0 ? word_order::high_first : word_order::low_first;
        is_factory_word_order_ = true;
    }

    constexpr bool has_next_part(const entry* e) const {
        return e->is_part() && e + 1 != map_->entries.data() + map_->entries.size() &&
               e[1].address == e->address;
    }

    constexpr void put_row_text(const entry& e, u16 at, words_view words, bool is_whole, kind how) {
        const std::size_t i = static_cast<u16>(at - first_);
        out_ << e.name;
        if (how != kind::values) put_address(out_, at);
        if (i < words.size()) {
            out_ << " = ";
            if (is_whole) {
                value(e, words, i, how);
            } else {
                out_.hex_word(words[i]);
            }
        }
        if (how == kind::request && words.size() != 0 && e.rights == access::ro) out_ << " (read-only)";
    }

    constexpr void value(const entry& e, words_view words, std::size_t i, kind how) {
        const word_order order = order_of(e);
        if (has_word_order(e) && order == word_order::unknown) {
            for (std::size_t k = 0; k < e.words(); ++k) out_.hex_word(words[i + k]) << ' ';
            out_ << "(word order unknown)";
            return;
        }
        const words_in_order own{e, words, i, order};
        if (is_text(e)) return put_text(out_, e, own);
        const entry* const by = scaling_row(e);
        put_row_value(out_, e, bits_of_words(e, own), value_format::words, scale_of(e, by, words),
                      by != nullptr ? static_cast<const char*>(by->name) : "?");
        if (how == kind::request) put_outside(out_, e, bits_of_words(e, own));
    }

    constexpr const entry* scaling_row(const entry& e) const {
        if (e.form == nullptr || e.form->scaled == scaling::none) return nullptr;
        const catalogue* const rows =
            e.form->scale_table == table::input_registers ? maps_.input_registers : maps_.holding_registers;
        return rows != nullptr ? rows->find(e.form->scale_address) : nullptr;
    }

    /// The scale of a row, if the frame has the row that gives it.
    constexpr row_scale scale_of(const entry& e, const entry* by, words_view words) const {
        if (by == nullptr || e.form->scale_table != in_ || by->address < first_) return unknown_scale(e);
        const std::size_t i = static_cast<std::size_t>(by->address) - first_;
        const bool is_known = !has_word_order(*by) || order_of(*by) != word_order::unknown;
        if (i + by->words() > words.size() || !is_known || is_text(*by)) return unknown_scale(e);
        return scale_from(e, *by,
                          value_of(*by, bits_of_words(*by, words_in_order{*by, words, i, order_of(*by)})));
    }

    static constexpr bool has_own_order(const entry& e) { return e.own_word_order != word_order::unknown; }
    constexpr word_order order_of(const entry& e) const {
        return has_own_order(e) ? e.own_word_order : word_order_;
    }

    /// Names the word of a value that the frame has in part.
    constexpr const char* piece_of(const entry& e, bool is_first) const {
        if (e.words() != 2 || is_text(e)) return "part of ";
        if (order_of(e) == word_order::unknown || (is_factory_word_order_ && !has_own_order(e)))
            return is_first ? "first word of " : "second word of ";
        return is_first == (order_of(e) == word_order::high_first) ? "high word of " : "low word of ";
    }

    // Writes consecutive addresses that the catalogue does not have. Returns how many there are.
    constexpr u16 unknown(u16 at, u16 most, words_view words, u16 i) {
        u16 n = 1;
        while (n < most && map_->find(static_cast<u16>(at + n)) == nullptr) ++n;
        out_ << (n == 1 ? "unknown register (" : "unknown registers (");
        out_.hex_word(at);
        if (n > 1) {
            out_ << "..";
            out_.hex_word(static_cast<u16>(at + n - 1));
        }
        out_ << ')';
        for (std::size_t k = i; k < words.size() && k < std::size_t{i} + n; ++k) {
            out_ << (k == i ? " = " : " ");
            out_.hex_word(words[k]);
        }
        return n;
    }

    table_catalogues maps_;
    const catalogue* map_; // of the table that the frame is about
    table in_ = table::holding_registers;
    u16 first_ = 0; // the address of the frame's first register
    word_order word_order_;
    bool is_factory_word_order_ = false; // `word_order_` is assumed; the text has a note
    text_writer& out_;
};

} // namespace servobus::detail
