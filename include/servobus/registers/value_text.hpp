// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Formats the words of any row of a catalogue as text, also of floats, 64 bits, texts, and parts of a register. A
// number may have a scale in another row. All digits are exact; there is no floating point.
// explain/explain.hpp includes it; tools include it.
//
//     constexpr auto room = [] {
//         std::array<char, 16> text{};
//         text_writer out{text};
//         return put_row(out, *zlac8015d::catalogue.find(0x20A1), std::array<u16, 1>{4820}), text; // "48.20 V"
//     }();
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/registers/format.hpp>
#include <servobus/registers/row_value.hpp>

namespace servobus {

namespace detail {

using scaled_integer = big_integer<8>; // 64 bits, twice 36 of a scale, 64 of a factor, 34 of an exponent

/// Writes an integer with `decimals` digits after the point; with zeros behind it if `decimals` is negative.
constexpr void put_decimal(text_writer& out, scaled_integer n, int decimals) {
    if (decimals < 0) n.multiply_by_power_of_ten(static_cast<unsigned>(-decimals));
    const unsigned after_point = decimals < 0 ? 0 : static_cast<unsigned>(decimals);
    char digits[80]{};
    unsigned count = 0;
    while ((!n.is_zero() || count <= after_point) && count < sizeof digits)
        digits[count++] = static_cast<char>('0' + static_cast<char>(n.divide(10)));
    while (count != 0) {
        out << digits[--count];
        if (count == after_point && count != 0) out << '.';
    }
}

/// Multiplies by a factor of `decimal_scale`, which may have more than 32 bits.
constexpr void multiply(scaled_integer& n, std::uint64_t by) {
    scaled_integer high = n;
    n.multiply(static_cast<std::uint32_t>(by));
    high.multiply(static_cast<std::uint32_t>(by >> 32));
    high.shift_left(32);
    n.add(high);
}

/// Writes a number times the scales; `1/3` if one of these is no decimal fraction.
constexpr void put_scaled(text_writer& out, const row_value& v, unit u, const row_scale& by) {
    const decimal_scale own = decimal_of(u), other = decimal_of(by.worth);
    scaled_integer n{v.magnitude};
    multiply(n, by.factor);
    if (v.is_negative != by.is_negative && !n.is_zero()) out << '-';
    if (own.is_decimal && other.is_decimal) {
        multiply(n, static_cast<std::uint64_t>(own.factor));
        multiply(n, static_cast<std::uint64_t>(other.factor));
        return put_decimal(out, n, static_cast<int>(own.decimals + other.decimals) - by.exponent);
    }
    n.multiply(u.numerator);
    n.multiply(by.worth.numerator);
    put_decimal(out, n, -by.exponent);
    out << '/';
    out.number(std::int64_t{u.denominator} * by.worth.denominator);
}

/// The exponent of a scale that is a power of ten.
struct power_of_ten {
    bool is_one = true;
    int exponent = 0;
};
constexpr power_of_ten power_of(unit u) {
    decimal_scale scale = decimal_of(u);
    power_of_ten p{scale.is_decimal, -static_cast<int>(scale.decimals)};
    for (; scale.factor % 10 == 0; scale.factor /= 10) ++p.exponent;
    p.is_one = p.is_one && scale.factor == 1;
    return p;
}

constexpr void put_real(text_writer& out, const float_bits& f, unit u) {
    const power_of_ten scale = power_of(u);
    put_float(out, f, scale.is_one ? scale.exponent : 0);
    if (scale.is_one) return;
    out << " * ";
    put_count(out, 1, u);
}

constexpr void put_raw_bits(text_writer& out, const entry& e, std::uint64_t bits) {
    out << "0x";
    const unsigned digits = (width_of(e) + 3) / 4;
    if (digits > 8) out.hex(static_cast<std::uint32_t>(bits >> 32), digits - 8);
    out.hex(static_cast<std::uint32_t>(bits), digits > 8 ? 8 : digits);
}

constexpr void put_character(text_writer& out, std::uint8_t byte) {
    if (byte >= ' ' && byte <= '~' && byte != '"' && byte != '\\') {
        out << static_cast<char>(byte);
    } else {
        out << "\\x";
        out.hex(byte, 2);
    }
}

} // namespace detail

/// Writes the number of a value, with its scale and without its unit. The value is a number or a float.
constexpr void put_number(text_writer& out, const entry& e, const row_value& v, const row_scale& scale = {}) {
    if (v.is == row_value::state::real) return detail::put_real(out, v.real, e.unit_of_count);
    detail::put_scaled(out, v, e.unit_of_count, scale);
}

/// True if a value has a number to write: it has one, and so has the row that scales it.
constexpr bool has_number(const row_value& v, const row_scale& scale) {
    using enum row_value::state;
    return (v.is == number || v.is == real) &&
           (scale.is == row_scale::state::none || scale.is == row_scale::state::known);
}
/// True for a value that reads as none: its own bits mean it, or those of the row that scales it.
constexpr bool has_no_value(const row_value& v, const row_scale& scale) {
    return v.is == row_value::state::no_value || scale.is == row_scale::state::no_value;
}

/// True if a bit's state has no name in its row, and is written as on or off: neither word names the other state.
constexpr bool is_on_or_off(const entry& e, bool is_on) {
    const char* const word = is_on ? "on" : "off";
    for (const named_value& v : e.values) {
        if (v.value == (is_on ? 1u : 0u)) return false;
        std::size_t i = 0;
        while (word[i] != '\0' && word[i] == v.name[i]) ++i;
        if (word[i] == v.name[i]) return false;
    }
    return true;
}

/// Writes the text that the words of a row hold, in quotes; characters that are not printable as `\x0A`. The text ends
/// before the first zero and the blanks at its end. If `keeps_all` is true, it ends before the zeros at its end.
template <class Words>
constexpr void put_text(text_writer& out, const entry& e, const Words& words, bool keeps_all = false) {
    const auto byte = [&](std::size_t i) {
        return static_cast<std::uint8_t>(i % 2 == 0 ? words[i / 2] >> 8 : words[i / 2] & 0xFFu);
    };
    std::size_t size = 2 * e.words();
    while (size != 0 && byte(size - 1) == 0) --size;
    for (std::size_t i = size; !keeps_all && i-- != 0;) {
        if (byte(i) == 0) size = i;
    }
    while (!keeps_all && size != 0 && byte(size - 1) == ' ') --size;
    out << '"';
    for (std::size_t i = 0; i < size; ++i) detail::put_character(out, byte(i));
    out << '"';
}

/// Writes the value of a row that is no text: `12.34 A`, `no_limit (0x00FF)`, `no value`. `scaled_by` is the name of
/// the row that scales it, for a scale that is not known: `1234 * 10^power_exponent W`.
constexpr void put_row_value(text_writer& out, const entry& e, std::uint64_t bits,
                             value_format how = value_format::words, const row_scale& scale = {},
                             const char* scaled_by = "?") {
    if (is_plain(e)) return put_value(out, e, static_cast<u32>(bits), how);
    const row_value v = value_of(e, bits);
    u32 named = 0;
    bool is_named = false;
    for (const named_value& n : e.values) {
        if (bits > 0xFFFF'FFFF || !n.applies(static_cast<u32>(bits))) continue;
        if (is_named) out << (how == value_format::tokens ? "+" : " + ");
        detail::put_name(out, n.name, how);
        named |= n.is_whole() ? n.value : n.mask;
        is_named = true;
    }
    if (is_named) {
        if (const std::uint64_t rest = bits & ~std::uint64_t{named}; rest != 0) {
            out << (how == value_format::tokens ? "+" : " + ");
            detail::put_raw_bits(out, e, rest);
        }
        out << " (";
        detail::put_raw_bits(out, e, bits);
        out << ')';
        return;
    }
    if (has_no_value(v, scale)) {
        out << "no value";
        return;
    }
    if (v.is == row_value::state::no_number) {
        out << "no number (";
        detail::put_raw_bits(out, e, bits);
        out << ')';
        return;
    }
    if (!e.is_quantity()) return detail::put_raw_bits(out, e, bits);
    put_number(out, e, v, scale);
    if (scale.is == row_scale::state::unknown)
        out << (e.form->scaled == scaling::exponent ? " * 10^" : " * ") << scaled_by;
    detail::put_symbol(out, e);
}

/// Writes the value of a row's words, the highest word first and the high byte first in each.
template <class Words>
constexpr void put_row(text_writer& out, const entry& e, const Words& words,
                       value_format how = value_format::words, const row_scale& scale = {},
                       const char* scaled_by = "?") {
    if (is_text(e)) return put_text(out, e, words);
    put_row_value(out, e, bits_of_words(e, words), how, scale, scaled_by);
}

} // namespace servobus
