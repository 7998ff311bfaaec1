// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value on its way into a register, and a value that came out of one. A constant is checked by the
// compiler; a run-time value enters by name, `checked(v)` or `clamped(v)`.
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/core/result.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus {

template <class V> struct checked_value { V value; };
template <class V> struct clamped_value { V value; };
template <class V> struct raw_value { V value; };

/// A run-time value; out of range it is refused (`errc::out_of_range`) and nothing is sent.
template <class V> constexpr checked_value<V> checked(V value) { return {value}; }
/// A run-time value; out of range it becomes the nearest value in range.
template <class V> constexpr clamped_value<V> clamped(V value) { return {value}; }
/// A count of a scaled register, said by name where a bare number could be taken for a quantity. The range
/// holds: a constant is checked by the compiler, `checked(raw(v))` at run time.
template <std::integral V> constexpr raw_value<V> raw(V value) { return {value}; }

/// The value 0 of a register in whose range it is without a stated meaning (`flag::zero_by_name`), such as a
/// drive's watchdog time: any other 0 is refused there.
///
///     drive.write<zlac8015d::host_timeout>(undocumented_zero{});
struct undocumented_zero {};

namespace detail {
/// The range that a value is checked against: of a row whose 0 is written by name only, from 1.
constexpr range writable(range within, flag flags) {
    if (has(flags, flag::zero_by_name) && within.low == 0) within.low = 1;
    return within;
}

// Not constexpr on purpose: a constant that calls one does not compile, and the error names the rule and, in
// its template arguments, the limits.
template <std::int64_t Low, std::int64_t High>
inline void this_constant_is_outside_the_range_of_the_register() {}
inline void this_quantity_is_no_whole_number_of_the_register_s_counts() {}

template <class V> struct is_quantity : std::false_type {};
template <unit U, class R> struct is_quantity<quantity<U, R>> : std::true_type {};
template <class V> struct is_raw : std::false_type {};
template <class V> struct is_raw<raw_value<V>> : std::true_type {};
template <class V> inline constexpr bool is_bool_or_character<raw_value<V>> = is_bool_or_character<V>;

template <const auto& R>
inline constexpr bool takes_bare_numbers =
    !has(R.flags, flag::scaled_elsewhere) && R.unit_of_count.is_plain() &&
    wire_integer<typename row_type<R>::value_type>;

} // namespace detail

/// A number of a register's counts, and why it is none.
struct counted {
    std::int64_t count;
    errc error;
};

/// What `value` is in counts of register `R`; `inexact` if it is no whole number of them. The register's range
/// is not looked at.
template <const auto& R, class V> constexpr counted count_of(V value) {
    using namespace detail;
    using T = typename row_type<R>::value_type;
    static_assert(!is_bool_or_character<V>, "a bool or a character is no number: give an integer");
    if constexpr (is_quantity<V>::value) {
        static_assert(!has(R.flags, flag::scaled_elsewhere),
                      "another register rescales this one: write it through the drive, or by raw()");
        static_assert(same_kind(V::unit_of_count, R.unit_of_count),
                      "the quantity is of another kind than the register");
        constexpr ratio r = conversion(V::unit_of_count, R.unit_of_count);
        if constexpr (r.denominator == 1) {
            return {scaled<r.numerator>(value.count()), errc::ok};
        } else if constexpr (!is_narrow<decltype(value.count())>) {
            const std::int64_t whole = widened(value.count()) / r.denominator;
            const bool exact = widened(value.count()) % r.denominator == 0;
            return {scaled<r.numerator>(whole), exact ? errc::ok : errc::inexact};
        } else { // 32 bits: a 64-bit division is dear on a small core
            const std::int32_t whole =
                static_cast<std::int32_t>(value.count()) / static_cast<std::int32_t>(r.denominator);
            const bool exact = whole * static_cast<std::int32_t>(r.denominator) == value.count();
            return {whole * r.numerator, exact ? errc::ok : errc::inexact};
        }
    } else if constexpr (is_raw<V>::value) {
        return {widened(value.value), errc::ok};
    } else if constexpr (std::same_as<V, T> && !wire_integer<T>) {
        return {std::int64_t{to_bits<T>(value)}, errc::ok};
    } else {
        static_assert(std::integral<V> && wire_integer<T>, "this register takes a value of its own type");
        static_assert(!has(R.flags, flag::scaled_elsewhere),
                      "another register rescales this one: write it through the drive, or by raw()");
        static_assert(takes_bare_numbers<R>, "this register is scaled: give a quantity, or a count by raw()");
        return {widened(value), errc::ok};
    }
}

namespace detail {
// A concept, since clang reads a bare constraint already when `setting` is asked about an array of
/// registers.
template <const auto& R>
concept takes_undocumented_zero = has(R.flags, flag::zero_by_name);
} // namespace detail

/// A value for register `R`, in range, or the reason why it is not.
template <const auto& R> class register_value {
    using row = row_type<R>;
    static_assert(row::rights != access::ro, "this register is read-only");

  public:
    using value_type = typename row::value_type;
    static constexpr range writable = detail::writable(R.limits, R.flags);

    /// A constant: out of range, scaled wrongly or of another kind it does not compile; nor does a bool or a
    /// character, here and in all that follows.
    template <class V> consteval register_value(V constant) { // NOLINT: implicit, `write<r>(500)`
        const counted c = count_of<R>(constant);
        if (c.error != errc::ok) detail::this_quantity_is_no_whole_number_of_the_register_s_counts();
        if (!writable.contains(c.count))
            detail::this_constant_is_outside_the_range_of_the_register<writable.low, writable.high>();
        bits_ = bits_of(c.count);
    }

    template <class V>
    constexpr register_value(checked_value<V> v) { // NOLINT: implicit, `write<r>(checked(v))`
        const counted c = count_of<R>(v.value);
        bits_ = bits_of(c.count);
        error_ = c.error != errc::ok ? c.error : writable.contains(c.count) ? errc::ok : errc::out_of_range;
    }

    template <class V>
    constexpr register_value(clamped_value<V> v) { // NOLINT: implicit, `write<r>(clamped(v))`
        const counted c = count_of<R>(v.value);
        error_ = c.error;
        bits_ = bits_of(c.count < writable.low    ? writable.low
                        : c.count > writable.high ? writable.high
                                                  : c.count);
    }

    /// 0, where only this writes it.
    constexpr register_value(undocumented_zero) // NOLINT: implicit, `write<r>(undocumented_zero{})`
        requires detail::takes_undocumented_zero<R> {}

    /// `ok`, `out_of_range` or `inexact`; a setting with an error is never sent.
    constexpr errc error() const { return error_; }
    /// The raw bits, two's complement, in the low half for a register of one word.
    constexpr u32 bits() const { return bits_; }

  private:
    static constexpr u32 bits_of(std::int64_t count) {
        return static_cast<u32>(static_cast<std::uint64_t>(count));
    }

    u32 bits_ = 0;
    errc error_ = errc::ok;
};

/// What the raw bits of register `R` mean, as a read gives it: see `reading`.
template <const auto& R> constexpr auto reading_of(u32 bits) {
    using T = typename row_type<R>::value_type;
    if constexpr (wire_integer<T> && R.unit_of_count.of != measure::none &&
                  !has(R.flags, flag::scaled_elsewhere)) {
        return quantity<R.unit_of_count, T>{from_bits<T>(bits)};
    } else {
        return from_bits<T>(bits);
    }
}

/// What reading `R` gives: a quantity with the register's unit; an enumeration or unpacked word as its own
/// type; a plain integer where there is no unit, or where another register sets the scale.
template <const auto& R> using reading = decltype(reading_of<R>(0));

} // namespace servobus
