// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The value that the words of a catalogue's row encode, and back, at run time. A row is an integer, a float, decimal
// digits or a part of a register, with an offset and raw values that mean "no value". There is no floating point.
// value_text.hpp includes it; tools include it.
//
//     constexpr value_form form{.offset = -1000};
//     constexpr entry row{182, "temperature", value_kind::unsigned_word, access::ro, full<u16>, no_default,
//                         unit{measure::degree_celsius, 1, 10}, flag::none, naming::number, {}, {}, &form};
//     static_assert(value_of(row, 1253).count() == 253);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/float_text.hpp>

namespace servobus {

/// True for a value that integers of one or two whole registers express, as those of drives.
constexpr bool is_plain(const entry& e) { return e.form == nullptr && e.kind <= value_kind::signed_pair; }
constexpr bool is_text(const entry& e) { return e.kind == value_kind::text; }
constexpr bool is_float(const entry& e) {
    return e.kind == value_kind::float_pair || e.kind == value_kind::float_quad;
}
constexpr bool is_bcd(const entry& e) {
    return e.kind == value_kind::bcd_word || e.kind == value_kind::bcd_pair;
}
constexpr bool is_sign_and_magnitude(const entry& e) {
    return e.kind == value_kind::sign_magnitude_word || e.kind == value_kind::sign_magnitude_pair;
}
/// True for an integer in two's complement.
constexpr bool is_two_complement(const entry& e) {
    return e.kind == value_kind::signed_word || e.kind == value_kind::signed_pair ||
           e.kind == value_kind::signed_quad;
}
/// True if the first word of several is the highest or the lowest. A text has its words in their order.
constexpr bool has_word_order(const entry& e) { return e.words() > 1 && !is_text(e); }

/// The bits that a row has, at most 64.
constexpr unsigned width_of(const entry& e) {
    return e.is_part() ? e.form->bits : 16u * static_cast<unsigned>(words_of(e.kind));
}
/// Ones for the bits that a row has.
constexpr std::uint64_t all_bits_of(const entry& e) { return ~std::uint64_t{0} >> (64 - width_of(e)); }

/// The bits of a row from its words, the highest word first and the high byte first in each. The row is no text.
template <class Words> constexpr std::uint64_t bits_of_words(const entry& e, const Words& words) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < e.words(); ++i) bits = bits << 16 | words[i];
    return e.is_part() ? (bits & e.form->mask()) >> e.form->first_bit : bits;
}

/// The words of a row as a device sends them, from the highest on and with the high byte first in each.
template <class Words> class words_in_order {
  public:
    constexpr words_in_order(const entry& e, const Words& words, std::size_t first, word_order order)
        : words_{&words}, first_{first}, last_{first + e.words() - 1},
          is_reversed_{order == word_order::low_first && has_word_order(e)}, is_low_byte_first_{
                                                                                 e.form != nullptr &&
                                                                                 e.form->is_low_byte_first} {}

    constexpr u16 operator[](std::size_t i) const {
        const unsigned word = (*words_)[is_reversed_ ? last_ - i : first_ + i];
        return static_cast<u16>(is_low_byte_first_ ? word << 8 | word >> 8 : word);
    }

  private:
    const Words* words_;
    std::size_t first_;
    std::size_t last_;
    bool is_reversed_;
    bool is_low_byte_first_;
};

/// The meaning of a row's bits.
struct row_value {
    enum class state : std::uint8_t {
        number,
        real,      ///< a finite float
        no_value,  ///< a raw value that means it, a NaN or an infinity
        no_number, ///< a decimal digit above 9, or a number beyond 64 bits
    };

    state is = state::number;
    bool is_negative = false;
    std::uint64_t magnitude = 0; ///< of a number: in counts, after the offset
    std::uint64_t bits = 0;
    float_bits real{};

    /// The number as an integer with a sign, the nearest one if it has none.
    constexpr std::int64_t count() const {
        constexpr auto most = static_cast<std::uint64_t>(detail::highest<std::int64_t>);
        if (!is_negative)
            return magnitude > most ? detail::highest<std::int64_t> : static_cast<std::int64_t>(magnitude);
        return magnitude > most ? detail::lowest<std::int64_t> : -static_cast<std::int64_t>(magnitude);
    }
};

namespace detail {

/// A sum with a sign; false if it is beyond 64 bits.
constexpr bool add_offset(row_value& v, std::int64_t offset) {
    const bool is_below = offset < 0;
    const std::uint64_t size =
        is_below ? 0 - static_cast<std::uint64_t>(offset) : static_cast<std::uint64_t>(offset);
    if (is_below == v.is_negative) {
        v.magnitude += size;
        return v.magnitude >= size;
    }
    if (v.magnitude < size) {
        v.magnitude = size - v.magnitude;
        v.is_negative = is_below;
    } else {
        v.magnitude -= size;
    }
    if (v.magnitude == 0) v.is_negative = false;
    return true;
}

/// False if a digit is above 9.
constexpr bool take_digits(row_value& v, unsigned width) {
    for (unsigned at = width; at != 0;) {
        at -= at % 4 == 0 ? 4 : at % 4; // the highest digit of a part may have fewer bits
        const std::uint64_t digit = v.bits >> at & 0xFu;
        if (digit > 9) return false;
        v.magnitude = 10 * v.magnitude + digit;
    }
    return true;
}

constexpr bool means_none(const entry& e, std::uint64_t bits) {
    if (e.form == nullptr) return false;
    for (const std::int64_t none : e.form->none) {
        if ((static_cast<std::uint64_t>(none) & all_bits_of(e)) == bits) return true;
    }
    return false;
}

} // namespace detail

/// The value of a row's bits. The row is no text.
constexpr row_value value_of(const entry& e, std::uint64_t bits) {
    using enum row_value::state;
    row_value v{.bits = bits};
    if (is_float(e)) {
        v.real = e.kind == value_kind::float_pair ? float_bits::of_single(static_cast<std::uint32_t>(bits))
                                                  : float_bits::of_double(bits);
        v.is = v.real.is_finite && !detail::means_none(e, bits) ? real : no_value;
        return v;
    }
    if (detail::means_none(e, bits)) {
        v.is = no_value;
        return v;
    }
    const unsigned width = width_of(e);
    const std::uint64_t sign = std::uint64_t{1} << (width - 1);
    v.magnitude = bits;
    if (is_bcd(e)) {
        v.magnitude = 0;
        if (!detail::take_digits(v, width)) v.is = no_number;
    } else if (is_sign_and_magnitude(e)) {
        v.magnitude = bits & ~sign;
        v.is_negative = bits > sign;
    } else if (is_two_complement(e) && (bits & sign) != 0) {
        v.magnitude = (0 - bits) & all_bits_of(e);
        v.is_negative = true;
    }
    const bool fits = e.form == nullptr || detail::add_offset(v, e.form->offset);
    if (!fits) v.is = no_number;
    return v;
}

/// The bits of a number, if the row has such.
struct number_bits {
    bool fits = false;
    std::uint64_t bits = 0;
};

/// The bits that encode a number of counts, which is after the offset. The row is neither a text nor a float.
constexpr number_bits bits_of_number(const entry& e, bool is_negative, std::uint64_t magnitude) {
    row_value v{.is_negative = is_negative && magnitude != 0, .magnitude = magnitude};
    if (e.form != nullptr && !detail::add_offset(v, -std::int64_t{e.form->offset})) return {};
    const std::uint64_t all = all_bits_of(e);
    const std::uint64_t sign = (all >> 1) + 1;
    if (is_bcd(e)) {
        number_bits found{.fits = !v.is_negative};
        unsigned at = 0;
        for (; v.magnitude != 0 && at < width_of(e); at += 4, v.magnitude /= 10)
            found.bits |= v.magnitude % 10 << at;
        found.fits = found.fits && v.magnitude == 0 && found.bits <= all;
        return found;
    }
    if (is_sign_and_magnitude(e))
        return {v.magnitude < sign, v.is_negative ? v.magnitude | sign : v.magnitude};
    if (is_two_complement(e))
        return {v.magnitude < sign + (v.is_negative ? 1 : 0),
                (v.is_negative ? 0 - v.magnitude : v.magnitude) & all};
    return {!v.is_negative && v.magnitude <= all, v.magnitude};
}
constexpr number_bits bits_of_number(const entry& e, std::int64_t number) {
    const auto size = static_cast<std::uint64_t>(number);
    return bits_of_number(e, number < 0, number < 0 ? 0 - size : size);
}

namespace detail {

/// True if a float is inside a range of whole numbers.
constexpr bool is_between(const float_bits& f, range within) {
    constexpr auto most = static_cast<std::uint64_t>(highest<std::int64_t>);
    std::uint64_t size = f.mantissa;
    bool is_whole = true;
    if (f.exponent < 0) {
        const auto shift = static_cast<unsigned>(-f.exponent);
        const std::uint64_t whole = shift < 64 ? size >> shift : 0;
        is_whole = shift < 64 ? whole << shift == size : size == 0;
        size = whole;
    } else if (size != 0) { // a size beyond all ranges is as good as the largest
        const auto shift = static_cast<unsigned>(f.exponent);
        size = shift < 63 && size <= most >> shift ? size << shift : most;
    }
    const auto inner = static_cast<std::int64_t>(size);
    const std::int64_t outer = is_whole || size == most ? inner : inner + 1;
    return f.is_negative ? -outer >= within.low && -inner <= within.high
                         : inner >= within.low && outer <= within.high;
}

} // namespace detail

/// True if the bits are a code that has a name.
constexpr bool is_named_code(const entry& e, std::uint64_t bits) {
    for (const named_value& v : e.values) {
        if (v.is_whole() && v.value == bits) return true;
    }
    return false;
}

/// True for what may be written: a value of the range, or a code that has a name.
constexpr bool takes(const entry& e, const row_value& v) {
    if (is_plain(e)) return e.takes(e.number(static_cast<u32>(v.bits)));
    if (is_named_code(e, v.bits)) return true;
    switch (v.is) {
    case row_value::state::number: return !e.limits.is_stated || e.limits.contains(v.count());
    case row_value::state::real: return !e.limits.is_stated || detail::is_between(v.real, e.limits);
    default: return false;
    }
}

/// The scale that another row gives to a row. Without one it is that of the row itself.
struct row_scale {
    enum class state : std::uint8_t {
        none,    ///< no other row scales it
        unknown, ///< the other row was not read
        known,
        no_value, ///< the other row has no value, or is an exponent outside -10..10
    };

    state is = state::none;
    bool is_negative = false;
    int exponent = 0;         ///< of ten
    std::uint64_t factor = 1; ///< counts of `worth`
    unit worth{};             ///< of a count of the other row
};

/// The scale of `e` if nothing is known of the row that scales it.
constexpr row_scale unknown_scale(const entry& e) {
    const bool is_scaled = e.form != nullptr && e.form->scaled != scaling::none;
    return {.is = is_scaled ? row_scale::state::unknown : row_scale::state::none};
}

/// The scale of `e` from the value of `by`, the row that scales it.
constexpr row_scale scale_from(const entry& e, const entry& by, const row_value& v) {
    constexpr std::uint64_t largest_exponent = 10;
    row_scale scale{.is = row_scale::state::known};
    const bool is_factor = e.form->scaled == scaling::factor;
    if (v.is != row_value::state::number || (!is_factor && v.magnitude > largest_exponent)) {
        scale.is = row_scale::state::no_value;
    } else if (is_factor) {
        scale.is_negative = v.is_negative;
        scale.factor = v.magnitude;
        scale.worth = by.unit_of_count;
    } else {
        scale.exponent = static_cast<int>(v.count());
    }
    return scale;
}

} // namespace servobus
