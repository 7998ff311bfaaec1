// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Formats a register's value as text: the number with its scale and unit, the names of codes and bits, or
// both halves of the word. Decimal fractions are exact; there is no floating point. Tools and
// explain/explain.hpp include it.
//
//     constexpr auto room = [] {
//         std::array<char, 16> text{};
//         text_writer out{text};
//         return put_value(out, *zlac8015d::catalogue.find(0x20A1), 4820), text; // "48.20 V"
//     }();
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/text.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/quantity_text.hpp>

namespace servobus {

/// How names are written.
enum class value_format : std::uint8_t {
    words,  ///< with spaces: `relative position`
    tokens, ///< without spaces, for scripts: `relative_position`
};

namespace detail {
constexpr void put_symbol(text_writer& out, const entry& e) {
    if (const char* const symbol = e.unit_symbol(); *symbol != '\0') out << ' ' << symbol;
}
} // namespace detail

/// Writes a raw count with the register's scale and unit: `12.5 A`.
constexpr void put_quantity(text_writer& out, const entry& e, std::int64_t count) {
    put_count(out, count, e.unit_of_count);
    detail::put_symbol(out, e);
}

namespace detail {

constexpr void put_name(text_writer& out, const char* name, value_format how) {
    for (; *name != '\0'; ++name) out << (how == value_format::tokens && *name == ' ' ? '_' : *name);
}

constexpr void put_bits(text_writer& out, const entry& e, u32 bits) {
    out << "0x";
    out.hex(bits, e.words() == 2 ? 8 : 4);
}

constexpr void put_names(text_writer& out, const entry& e, u32 bits, value_format how) {
    u32 named = 0;
    bool is_first = true;
    for (const named_value& v : e.values) {
        if (!v.applies(bits)) continue;
        if (!is_first) out << (how == value_format::tokens ? "+" : " + ");
        put_name(out, v.name, how);
        named |= v.is_whole() ? v.value : v.mask;
        is_first = false;
    }
    if (is_first) return e.is_quantity() ? put_quantity(out, e, e.number(bits)) : put_bits(out, e, bits);
    if (const u32 rest = bits & ~named; rest != 0) {
        out << (how == value_format::tokens ? "+" : " + ");
        put_bits(out, e, rest);
    }
    out << " (";
    put_bits(out, e, bits);
    out << ')';
}

constexpr void put_halves(text_writer& out, const entry& e, u16 word, value_format how) {
    const auto half = [&](unsigned byte) -> std::int64_t {
        return e.is_signed() ? std::int64_t{static_cast<std::int8_t>(byte)} : std::int64_t{byte};
    };
    if (how == value_format::words) out << "left ";
    put_count(out, half(word >> 8), e.unit_of_count);
    if (how == value_format::words) put_symbol(out, e);
    out << (how == value_format::words ? " / right " : "/");
    put_count(out, half(word & 0xFFu), e.unit_of_count);
    put_symbol(out, e);
}
} // namespace detail

/// Writes the meaning of a register's raw bits: `12.5 A`, `enable (0x0008)`, `left 35 degC / right 36 degC`;
/// of a number that has names for some values the name, or the number with its unit.
/// For a register that another register rescales (`flag::scaled_elsewhere`) it uses the factory's scale;
/// callers append `factory_scale_note`.
constexpr void put_value(text_writer& out, const entry& e, u32 bits, value_format how = value_format::words) {
    switch (e.names) {
    case naming::names: return detail::put_names(out, e, e.words() == 2 ? bits : bits & 0xFFFF, how);
    case naming::halves:
        if (e.words() == 2) break; // a pair has no halves of one byte
        return detail::put_halves(out, e, static_cast<u16>(bits), how);
    case naming::number: break;
    }
    put_quantity(out, e, e.number(bits));
}

/// A note to append to the value of a register that another register rescales.
inline constexpr const char* factory_scale_note = " (at the factory's scale)";

} // namespace servobus
