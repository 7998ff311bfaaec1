// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coils and discrete inputs of a frame as text: their names and those of their states from the catalogues, and what has
// no name by its addresses.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/text.hpp>
#include <servobus/explain/detail/function_names.hpp>
#include <servobus/explain/detail/register_text.hpp>
#include <servobus/explain/direction.hpp>
#include <servobus/explain/table_catalogues.hpp>
#include <servobus/modbus/bits.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/value_text.hpp>

namespace servobus::detail {

class bit_text {
  public:
    using kind = register_text::kind;

    constexpr bit_text(const table_catalogues& maps, text_writer& out)
        : coils_{maps.coils}, discrete_inputs_{maps.discrete_inputs}, out_{out} {}

    /// Writes "read pump (0x0004)" or "write pump (0x0004) = on".
    constexpr void put_request(bytes pdu) {
        if (is_unusual_coil_write(pdu)) {
            out_ << "write ";
            return put_unusual(pdu, kind::request);
        }
        const modbus::bits_request r = *modbus::parse_bits_request(pdu);
        out_ << (r.is_read() ? "read " : "write ");
        put(r.code, r.address, r.quantity, r.is_read() ? modbus::bits_view{} : r.coils(), kind::request);
    }

    /// Writes the words of a response to function 05 or 0Fh; the one to 0Fh has no values.
    constexpr void put_written(bytes pdu) {
        if (is_unusual_coil_write(pdu)) {
            put_unusual(pdu, kind::response);
        } else if (static_cast<modbus::function>(pdu[0]) == modbus::function::write_single_coil) {
            const modbus::bits_request same = *modbus::parse_bits_request(pdu);
            put(same.code, same.address, same.quantity, same.coils(), kind::response);
        } else {
            put(modbus::function::write_multiple_coils, load_word(pdu, 1), load_word(pdu, 3), {},
                kind::response);
        }
        out_ << " written";
    }

    /// Writes the states that a response has, without names if `request` is empty.
    constexpr void put_read(bytes pdu, bytes request) {
        if (request.empty()) {
            put_number_of(out_, pdu[1], "byte");
            out_ << " of " << bit_of(static_cast<modbus::function>(pdu[0])) << 's';
            return put_bytes(out_, pdu.subspan(2));
        }
        const modbus::bits_request asked = *modbus::parse_bits_request(request);
        put(asked.code, asked.address, asked.quantity, {pdu.subspan(2), asked.quantity}, kind::values);
    }

  private:
    static constexpr const char* bit_of(modbus::function code) {
        return code == modbus::function::read_discrete_inputs ? "discrete input" : "coil";
    }

    /// Writes "valve (0x000D) = toggle (0x5500)" if the row has a name for the word, else
    /// "valve (0x000D) = 0x5500 (no value of the standard)".
    constexpr void put_unusual(bytes pdu, kind how) {
        const u16 word = load_word(pdu, 3);
        put(modbus::function::write_single_coil, load_word(pdu, 1), 1, {}, how);
        out_ << " = ";
        const entry* const e = coils_ != nullptr ? coils_->find(load_word(pdu, 1)) : nullptr;
        if (e != nullptr && is_named_code(*e, word)) return put_value(out_, *e, word);
        out_.hex_word(word);
        out_ << " (no value of the standard)";
    }

    /// Writes the names of bits and, if `states` is not empty, their states: "valve (0x0003) = open (0x0001), …".
    constexpr void put(modbus::function code, u16 address, u16 quantity, modbus::bits_view states, kind how) {
        const catalogue* map = code == modbus::function::read_discrete_inputs ? discrete_inputs_ : coils_;
        const auto find = [&](std::size_t i) {
            return map == nullptr ? nullptr : map->find(static_cast<u16>(address + i));
        };
        for (std::size_t i = 0; i < quantity;) {
            if (i != 0) out_ << ", ";
            if (const entry* e = find(i)) {
                put_named(*e, states, i, how);
                ++i;
                continue;
            }
            const std::size_t first = i;
            do ++i;
            while (i < quantity && find(i) == nullptr);
            put_range(bit_of(code), static_cast<u16>(address + first), i - first);
            if (states.size() == 0) continue;
            out_ << " = ";
            put_states(states, first, i);
        }
    }

    constexpr void put_named(const entry& e, modbus::bits_view states, std::size_t i, kind how) {
        out_ << e.name;
        if (how != kind::values) put_address(out_, e.address);
        if (states.size() == 0) return;
        out_ << " = ";
        const bool is_on = states[i];
        if (is_on_or_off(e, is_on)) {
            out_ << on_or_off(is_on);
        } else {
            put_value(out_, e, is_on);
        }
        if (how != kind::request) return;
        put_outside(out_, e, is_on);
        if (e.rights == access::ro) out_ << " (read-only)";
    }

    /// Writes "coil 0x00AC", "coils 0x0013..0x0025".
    constexpr void put_range(const char* what, u16 first, std::size_t count) {
        out_ << what << (count == 1 ? " " : "s ");
        out_.hex_word(first);
        if (count == 1) return;
        out_ << "..";
        out_.hex_word(static_cast<u16>(first + count - 1));
    }

    static constexpr const char* on_or_off(bool is_on) { return is_on ? "on" : "off"; }

    /// Writes on or off for one bit; several as digits in groups of eight, that of the lowest address first.
    constexpr void put_states(modbus::bits_view states, std::size_t begin, std::size_t end) {
        if (end - begin == 1) {
            out_ << on_or_off(states[begin]);
            return;
        }
        for (std::size_t i = begin; i < end; ++i) {
            if (i != begin && (i - begin) % 8 == 0) out_ << ' ';
            out_ << (states[i] ? '1' : '0');
        }
    }

    const catalogue* coils_;
    const catalogue* discrete_inputs_;
    text_writer& out_;
};

} // namespace servobus::detail
