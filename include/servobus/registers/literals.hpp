// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Literals of quantities: decimals in the units of a machine, without floating point. `12.5_r_per_min` counts tenths of
// r/min, `652.3_mm` tenths of a millimetre. A number that is no plain decimal does not compile.
//
//     using namespace servobus::literals;
//     static_assert(12.5_r_per_min == 125 * part<10>(units::r_per_min));
//     static_assert(1_revolution == 360_degree && 0.4_mm == 400_um);
//     static_assert((1.5_s).in(units::millisecond) == 1500);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
/// A decimal: `count` of `parts` parts, a power of ten; or why the text is none.
struct decimal {
    enum class fault : std::uint8_t { none, no_plain_decimal, too_many_decimals, too_large };

    std::int32_t count = 0;
    std::uint16_t parts = 1;
    fault why = fault::none;
};

template <std::size_t Size> consteval decimal decimal_of(const char (&text)[Size]) {
    std::int64_t count = 0;
    std::uint32_t parts = 1;
    bool has_point = false;
    bool is_octal = Size > 1 && text[0] == '0' && text[Size > 1 ? 1 : 0] != '.';
    for (const char c : text) {
        if (c == '\'') continue;
        if (c == '.') {
            has_point = true;
            is_octal = false; // 007.5 is a decimal
            continue;
        }
        if (c < '0' || c > '9') return {.why = decimal::fault::no_plain_decimal};
        count = count * 10 + (c - '0');
        if (has_point) parts *= 10;
        if (count > highest<std::int32_t>) return {.why = decimal::fault::too_large};
        if (parts > 1'000'000'000) return {.why = decimal::fault::too_many_decimals};
    }
    if (is_octal) return {.why = decimal::fault::no_plain_decimal};
    while (parts != 1 && count % 10 == 0) {
        count /= 10;
        parts /= 10;
    }
    if (parts > 10'000) return {.why = decimal::fault::too_many_decimals};
    return {static_cast<std::int32_t>(count), static_cast<std::uint16_t>(parts)};
}

// No consteval: clang 14 leaves a call to it in a template. The number is a constant all the same.
template <unit U, char... Characters> constexpr auto literal_of() {
    constexpr decimal d = decimal_of({Characters...});
    static_assert(d.why != decimal::fault::no_plain_decimal, "a_quantity_is_a_plain_decimal_such_as_12_5");
    static_assert(d.why != decimal::fault::too_many_decimals, "a_quantity_has_at_most_4_decimals");
    static_assert(d.why != decimal::fault::too_large, "a_quantity_fits_32_bits");
    return quantity<U / d.parts, std::int32_t>{d.count};
}
} // namespace detail

/// The suffixes are the symbols of the units, `_per_` for a stroke. A sign stands before: `-0.4_mm`.
namespace literals {
// clang-format off
template <char... C> constexpr auto operator""_us()         { return detail::literal_of<units::microsecond, C...>(); }
template <char... C> constexpr auto operator""_ms()         { return detail::literal_of<units::millisecond, C...>(); }
template <char... C> constexpr auto operator""_s()          { return detail::literal_of<units::second, C...>(); }

template <char... C> constexpr auto operator""_um()         { return detail::literal_of<units::micrometre, C...>(); }
template <char... C> constexpr auto operator""_mm()         { return detail::literal_of<units::millimetre, C...>(); }
template <char... C> constexpr auto operator""_m()          { return detail::literal_of<units::metre, C...>(); }
template <char... C> constexpr auto operator""_um_per_s()   { return detail::literal_of<units::micrometre_per_second, C...>(); }
template <char... C> constexpr auto operator""_mm_per_s()   { return detail::literal_of<units::millimetre_per_second, C...>(); }
template <char... C> constexpr auto operator""_m_per_s()    { return detail::literal_of<units::metre_per_second, C...>(); }

template <char... C> constexpr auto operator""_degree()     { return detail::literal_of<units::degree, C...>(); }
template <char... C> constexpr auto operator""_revolution() { return detail::literal_of<units::revolution, C...>(); }
template <char... C> constexpr auto operator""_urad()       { return detail::literal_of<units::microradian, C...>(); }
template <char... C> constexpr auto operator""_mrad()       { return detail::literal_of<units::milliradian, C...>(); }
template <char... C> constexpr auto operator""_rad()        { return detail::literal_of<units::radian, C...>(); }
template <char... C> constexpr auto operator""_urad_per_s() { return detail::literal_of<units::microradian_per_second, C...>(); }
template <char... C> constexpr auto operator""_mrad_per_s() { return detail::literal_of<units::milliradian_per_second, C...>(); }
template <char... C> constexpr auto operator""_rad_per_s()  { return detail::literal_of<units::radian_per_second, C...>(); }

template <char... C> constexpr auto operator""_r_per_min()  { return detail::literal_of<units::r_per_min, C...>(); }
template <char... C> constexpr auto operator""_pulse()      { return detail::literal_of<units::pulse, C...>(); }
template <char... C> constexpr auto operator""_mA()         { return detail::literal_of<units::milliampere, C...>(); }
template <char... C> constexpr auto operator""_A()          { return detail::literal_of<units::ampere, C...>(); }
template <char... C> constexpr auto operator""_V()          { return detail::literal_of<units::volt, C...>(); }
template <char... C> constexpr auto operator""_percent()    { return detail::literal_of<units::percent, C...>(); }
// clang-format on
} // namespace literals

} // namespace servobus
