// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Units and quantities. A register's unit is arithmetic on named units: `ampere / 10` means that one count is
// 0.1 A. A quantity is an integer count of a unit. Conversions are exact or do not compile; there is no
// floating point. Register maps include it; programs include it for values with units.
//
//     constexpr quantity<unit{measure::milliampere}> limit = 3 * units::ampere; // exact
//     static_assert(limit.count() == 3000);
//     static_assert((12'500 * units::milliampere).rounded(units::ampere) == 13);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <compare>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/core/time.hpp>
#include <servobus/registers/measure.hpp>

namespace servobus {

namespace detail {
// The limits of an integer type. <limits> has them too, but fails where min and max are macros.
template <class T>
inline constexpr T highest = static_cast<T>(static_cast<std::make_unsigned_t<T>>(-1) >>
                                            (std::is_signed_v<T> ? 1 : 0));
template <class T> inline constexpr T lowest = std::is_signed_v<T> ? static_cast<T>(-highest<T> - 1) : T{0};

// Integral types of the language that are not meant as numbers. `signed char` and `unsigned char` are
// numbers of 8 bits.
template <class T> inline constexpr bool is_bool_or_character = false;
template <> inline constexpr bool is_bool_or_character<bool> = true;
template <> inline constexpr bool is_bool_or_character<char> = true;
template <> inline constexpr bool is_bool_or_character<wchar_t> = true;
template <> inline constexpr bool is_bool_or_character<char8_t> = true;
template <> inline constexpr bool is_bool_or_character<char16_t> = true;
template <> inline constexpr bool is_bool_or_character<char32_t> = true;

} // namespace detail

/// Fails to compile if `N` is not a type for counts: a bool, a character, a floating-point number.
template <class N> constexpr void check_count() {
    static_assert(!detail::is_bool_or_character<N>, "a bool or a character is no number: give an integer");
    static_assert(!std::floating_point<N>,
                  "a quantity is a whole number of its unit: 0.5 s is 500 * millisecond, or 5 * "
                  "part<10>(second)");
}

/// The worth of one count of a register: `numerator / denominator` of a measure.
struct unit {
    measure of = measure::none;
    std::uint16_t numerator = 1;
    std::uint16_t denominator = 1;

    friend constexpr bool operator==(const unit&, const unit&) = default;
    friend constexpr unit operator*(std::uint32_t n, unit u) {
        return {u.of, product(n, u.numerator), u.denominator};
    }
    friend constexpr unit operator/(unit u, std::uint32_t n) {
        return {u.of, u.numerator, product(n, u.denominator)};
    }
    /// True if one count is one whole unit of the measure, so that a bare number is unambiguous.
    constexpr bool is_plain() const { return numerator == denominator; }

  private:
    // Not constexpr on purpose: a constant unit that calls it does not compile.
    static void a_unit_is_at_most_65535_times_finer_or_coarser() {}
    static constexpr std::uint16_t product(std::uint32_t a, std::uint32_t b) {
        if (a == 0 || b == 0 || a > 0xFFFFu || a * b > 0xFFFFu)
            a_unit_is_at_most_65535_times_finer_or_coarser();
        return static_cast<std::uint16_t>(a * b);
    }
};

namespace detail {

struct ratio {
    std::int64_t numerator = 1;
    std::int64_t denominator = 1;
};

constexpr std::int64_t common_divisor(std::int64_t a, std::int64_t b) {
    while (b != 0) {
        const std::int64_t r = a % b;
        a = b;
        b = r;
    }
    return a;
}

/// How many counts of `to` one count of `from` is, as a reduced fraction.
constexpr ratio conversion(unit from, unit to) {
    const std::int64_t n =
        std::int64_t{from.numerator} * bases_in(from.of) * to.denominator * parts_of_base(to.of);
    const std::int64_t d =
        std::int64_t{from.denominator} * parts_of_base(from.of) * to.numerator * bases_in(to.of);
    const std::int64_t g = common_divisor(n, d);
    return {n / g, d / g};
}

/// `v`, limited to the range of `Rep`.
template <std::integral Rep> constexpr Rep saturated(std::int64_t v) {
    constexpr std::int64_t low = detail::lowest<Rep>;
    constexpr std::int64_t high = detail::highest<Rep>;
    return static_cast<Rep>(v < low ? low : v > high ? high : v);
}

/// Converts to signed 64 bits; unsigned numbers that do not fit become the largest.
template <std::integral N> constexpr std::int64_t widened(N v) {
    if constexpr (std::unsigned_integral<N> && sizeof(N) == 8) {
        constexpr auto most = static_cast<N>(detail::highest<std::int64_t>);
        return static_cast<std::int64_t>(v < most ? v : most);
    } else {
        return v;
    }
}

/// `Factor` times `v`, limited to the range of 64 bits.
template <std::int64_t Factor, std::integral N> constexpr std::int64_t scaled(N v) {
    if constexpr (sizeof(N) <= 4 && Factor <= 0x7FFF'FFFF) {
        return std::int64_t{v} * Factor;
    } else {
        constexpr std::int64_t most = detail::highest<std::int64_t> / Factor;
        const std::int64_t wide = widened(v);
        if (wide > most) return detail::highest<std::int64_t>;
        return wide < -most ? detail::lowest<std::int64_t> : wide * Factor;
    }
}

/// `a + b` and `a - b`, limited to the range of 64 bits.
constexpr std::int64_t more(std::int64_t a, std::int64_t b) {
    constexpr std::int64_t low = detail::lowest<std::int64_t>;
    constexpr std::int64_t high = detail::highest<std::int64_t>;
    if (b > 0 && a > high - b) return high;
    if (b < 0 && a < low - b) return low;
    return a + b;
}
constexpr std::int64_t less(std::int64_t a, std::int64_t b) {
    constexpr std::int64_t low = detail::lowest<std::int64_t>;
    constexpr std::int64_t high = detail::highest<std::int64_t>;
    if (b < 0 && a > high + b) return high;
    if (b > 0 && a < low + b) return low;
    return a - b;
}

/// True if every `N` fits signed 32 bits.
template <class N>
inline constexpr bool is_narrow = sizeof(N) < 4 || (sizeof(N) == 4 && std::signed_integral<N>);

constexpr bool same_kind(unit a, unit b) { return base_of(a.of) == base_of(b.of); }

} // namespace detail

namespace detail {
constexpr unit of_durations{measure::microsecond};
// Not constexpr on purpose: a constant duration that calls it does not compile.
inline void a_duration_is_a_whole_number_of_the_unit() {}
inline void a_duration_fits_the_quantity() {}
} // namespace detail

/// A quantity as an integer count of unit `U`: `quantity<unit{measure::r_per_min, 1, 10}>` counts tenths of
/// r/min.
template <unit U, std::integral Rep = std::int32_t> class quantity {
  public:
    static constexpr unit unit_of_count = U;

    constexpr quantity() = default;
    constexpr explicit quantity(Rep count) : count_{count} {}
    /// Rejects a bool, a character and a floating-point number at compile time.
    template <class N>
    requires(detail::is_bool_or_character<N> || std::floating_point<N>) constexpr explicit quantity(N) {
        check_count<N>();
    }

    /// Converts a quantity of the same or a coarser unit, which is always exact. The result is limited to the
    /// range of `Rep`.
    template <unit V, std::integral R>
    requires((V != U || !std::same_as<R, Rep>)&&detail::same_kind(U, V) &&
             detail::conversion(V, U).denominator ==
                 1) constexpr quantity(quantity<V, R> other) // NOLINT: implicit, since exact
        : count_{detail::saturated<Rep>(detail::scaled<detail::conversion(V, U).numerator>(other.count()))} {}

    /// Converts a constant duration, `milliseconds(500)`, that is a whole number of `U`.
    consteval quantity(duration d) requires(
        detail::same_kind(U, detail::of_durations)) { // NOLINT: implicit, since exact
        constexpr detail::ratio r = detail::conversion(detail::of_durations, U);
        const std::int64_t parts = std::int64_t{d.us} * r.numerator;
        if (parts % r.denominator != 0) detail::a_duration_is_a_whole_number_of_the_unit();
        if (parts / r.denominator > detail::highest<Rep>) detail::a_duration_fits_the_quantity();
        count_ = static_cast<Rep>(parts / r.denominator);
    }
    /// Converts a time of whole microseconds to a duration, limited to 0 and to 4294 s.
    constexpr operator duration() const
        requires(detail::same_kind(U, detail::of_durations)) { // NOLINT: likewise
        constexpr detail::ratio r = detail::conversion(U, detail::of_durations);
        static_assert(r.denominator == 1, "a duration is a whole number of microseconds");
        return duration{detail::saturated<std::uint32_t>(detail::scaled<r.numerator>(count_))};
    }

    /// The count of `U`; for a value read from a register, its raw value.
    constexpr Rep count() const { return count_; }

    /// The quantity as a count of `Unit`, limited to 32 bits. It compiles only if one count of `U` is a whole
    /// number of `Unit`.
    template <class Unit> constexpr std::int32_t in(Unit) const {
        constexpr detail::ratio r = detail::conversion(U, Unit::value);
        static_assert(detail::same_kind(U, Unit::value), "the quantity is of another kind than this unit");
        static_assert(r.denominator == 1, "a count is no whole number of this unit: use rounded()");
        return detail::saturated<std::int32_t>(detail::scaled<r.numerator>(count_));
    }

    /// The quantity as a count of `Unit`, rounded to the nearest; halves are rounded away from zero.
    template <class Unit> constexpr std::int32_t rounded(Unit) const {
        static_assert(detail::same_kind(U, Unit::value), "the quantity is of another kind than this unit");
        constexpr detail::ratio r = detail::conversion(U, Unit::value);
        const auto scaled = detail::saturated<std::int32_t>(detail::scaled<r.numerator>(count_));
        if constexpr (r.denominator > detail::highest<std::int32_t>) { // no whole one in 32 bits
            constexpr std::int64_t half = r.denominator - r.denominator / 2;
            return scaled >= half ? 1 : scaled <= -half ? -1 : 0;
        } else {
            constexpr auto d = static_cast<std::int32_t>(r.denominator);
            const std::int32_t whole = scaled / d;
            const std::int32_t rest = scaled % d; // rounding by the remainder cannot overflow
            if (rest >= d - d / 2) return whole + 1;
            return rest <= d / 2 - d ? whole - 1 : whole;
        }
    }

    friend constexpr bool operator==(quantity, quantity) = default;
    friend constexpr auto operator<=>(quantity, quantity) = default;
    // Sums and differences are limited to the range of `Rep`, like conversions.
    friend constexpr quantity operator-(quantity a) {
        return quantity{detail::saturated<Rep>(detail::less(0, detail::widened(a.count_)))};
    }
    friend constexpr quantity operator+(quantity a, quantity b) {
        return quantity{
            detail::saturated<Rep>(detail::more(detail::widened(a.count_), detail::widened(b.count_)))};
    }
    friend constexpr quantity operator-(quantity a, quantity b) {
        return quantity{
            detail::saturated<Rep>(detail::less(detail::widened(a.count_), detail::widened(b.count_)))};
    }

    template <unit V, std::integral R>
    requires((V != U || !std::same_as<R, Rep>)&&detail::same_kind(U, V)) friend constexpr auto
    operator<=>(quantity a, quantity<V, R> b) {
        constexpr detail::ratio r = detail::conversion(U, V);
        return detail::scaled<r.numerator>(a.count_) <=> detail::scaled<r.denominator>(b.count());
    }
    template <unit V, std::integral R>
    requires((V != U || !std::same_as<R, Rep>)&&detail::same_kind(U, V)) friend constexpr bool
    operator==(quantity a, quantity<V, R> b) {
        return (a <=> b) == 0;
    }

  private:
    Rep count_{};
};

/// A time of a clock against a quantity of time: `since(began, now) > 500_ms`. Exact; no quantity is limited for it.
template <unit U, std::integral Rep>
requires(detail::same_kind(U, detail::of_durations)) constexpr auto operator<=>(duration a,
                                                                                quantity<U, Rep> b) {
    return quantity<detail::of_durations, std::int64_t>{a.us} <=> b;
}
template <unit U, std::integral Rep>
requires(detail::same_kind(U, detail::of_durations)) constexpr bool operator==(duration a,
                                                                               quantity<U, Rep> b) {
    return (a <=> b) == 0;
}

/// Does not compile: the count would be rounded.
template <unit U, std::integral Rep, std::integral N>
constexpr quantity<U, Rep> operator/(quantity<U, Rep> whole, N) {
    static_assert(
        sizeof(N) == 0,
        "a quantity is a whole number of its unit and is not divided: 12.5 V is 125 * part<10>(volt)");
    return whole;
}

/// A unit as a type, so that `30 * r_per_min` is a quantity of that unit.
template <unit U> struct unit_constant {
    static constexpr unit value = U;

    constexpr operator unit() const { return U; } // NOLINT: a register's row takes it as data

    /// A quantity of `count` units. Its representation has 32 bits, or 64 bits if the type of `count` may not
    /// fit 32. A bool, a character and a floating-point number do not compile.
    template <std::integral N> friend constexpr auto operator*(N count, unit_constant) {
        check_count<N>();
        if constexpr (detail::is_narrow<N>) {
            return quantity<U, std::int32_t>{static_cast<std::int32_t>(count)};
        } else {
            return quantity<U, std::int64_t>{detail::widened(count)};
        }
    }
    template <std::floating_point N> friend constexpr quantity<U, std::int32_t> operator*(N, unit_constant) {
        check_count<N>();
        return {};
    }
    friend constexpr unit operator/(unit_constant, int n) { return U / static_cast<std::uint32_t>(n); }
};

/// The N-th part of a unit, as a unit: `125 * part<10>(r_per_min)` is 12.5 r/min.
template <std::uint16_t N, unit U> constexpr unit_constant<U / N> part(unit_constant<U>) { return {}; }

/// N times a unit, as a unit: `5 * multiple<10>(millisecond)` is 50 ms.
template <std::uint16_t N, unit U> constexpr unit_constant<N * U> multiple(unit_constant<U>) { return {}; }

/// The unit of a register that holds a code or a plain number.
inline constexpr unit no_unit{};

/// The named units. They have their own namespace, since names such as `second` and `count` are common. Those of meters
/// and sensors are in meter_units.hpp.
namespace units {
inline constexpr unit_constant<unit{measure::r_per_min}> r_per_min{};
inline constexpr unit_constant<unit{measure::second}> second{};
inline constexpr unit_constant<unit{measure::millisecond}> millisecond{};
inline constexpr unit_constant<unit{measure::ampere}> ampere{};
inline constexpr unit_constant<unit{measure::milliampere}> milliampere{};
inline constexpr unit_constant<unit{measure::milliampere_per_second}> milliampere_per_second{};
inline constexpr unit_constant<unit{measure::volt}> volt{};
inline constexpr unit_constant<unit{measure::percent}> percent{};
inline constexpr unit_constant<unit{measure::degree_celsius}> degree_celsius{};
inline constexpr unit_constant<unit{measure::degree}> degree{};
inline constexpr unit_constant<unit{measure::pulse}> pulse{};
inline constexpr unit_constant<unit{measure::nanosecond}> nanosecond{};
inline constexpr unit_constant<unit{measure::millivolt}> millivolt{};
inline constexpr unit_constant<unit{measure::ohm}> ohm{};
inline constexpr unit_constant<unit{measure::watt}> watt{};
inline constexpr unit_constant<unit{measure::kilohertz}> kilohertz{};
inline constexpr unit_constant<unit{measure::hertz}> hertz{};
inline constexpr unit_constant<unit{measure::times}> times{};
inline constexpr unit_constant<unit{measure::revolution}> revolution{};
inline constexpr unit_constant<unit{measure::pulse_per_revolution}> pulse_per_revolution{};
inline constexpr unit_constant<unit{measure::reference_unit}> reference_unit{};
inline constexpr unit_constant<unit{measure::count}> count{};
inline constexpr unit_constant<unit{measure::microsecond}> microsecond{};
inline constexpr unit_constant<unit{measure::micrometre}> micrometre{};
inline constexpr unit_constant<unit{measure::millimetre}> millimetre{};
inline constexpr unit_constant<unit{measure::metre}> metre{};
inline constexpr unit_constant<unit{measure::micrometre_per_second}> micrometre_per_second{};
inline constexpr unit_constant<unit{measure::millimetre_per_second}> millimetre_per_second{};
inline constexpr unit_constant<unit{measure::metre_per_second}> metre_per_second{};
inline constexpr unit_constant<unit{measure::microradian}> microradian{};
inline constexpr unit_constant<unit{measure::milliradian}> milliradian{};
inline constexpr unit_constant<unit{measure::radian}> radian{};
inline constexpr unit_constant<unit{measure::microradian_per_second}> microradian_per_second{};
inline constexpr unit_constant<unit{measure::milliradian_per_second}> milliradian_per_second{};
inline constexpr unit_constant<unit{measure::radian_per_second}> radian_per_second{};
} // namespace units

} // namespace servobus
