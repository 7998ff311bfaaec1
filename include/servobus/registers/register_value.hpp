// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Values to be written to a register, and values read from one. A constant is checked by the compiler; a
// run-time value is passed as `checked(v)` or `clamped(v)`. client/client.hpp includes it.
//
//     constexpr register_value<zlac8015d::host_timeout> half_a_second = 500 * units::millisecond;
//     constexpr register_value<zlac8015d::host_timeout> too_long = checked(40'000);
//     static_assert(half_a_second.bits() == 500 && too_long.error() == errc::out_of_range);
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/core/result.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus {

/// What `checked` returns.
template <class V> struct checked_value { V value; };
/// What `clamped` returns.
template <class V> struct clamped_value { V value; };
/// What `raw` returns.
template <class V> struct raw_value { V value; };

/// Passes a run-time value. If it is out of range, the write is refused (`errc::out_of_range`) and nothing is
/// sent.
template <class V> constexpr checked_value<V> checked(V value) { return {value}; }
/// Passes a run-time value. If it is out of range, the nearest value in range is written.
template <class V> constexpr clamped_value<V> clamped(V value) { return {value}; }
/// Passes a raw count to a scaled register, which takes no bare numbers. The range applies: the compiler
/// checks a constant; run-time values are passed as `checked(raw(v))` or `clamped(raw(v))`.
template <std::integral V> constexpr raw_value<V> raw(V value) { return {value}; }

/// The value 0 of a register whose manual states no meaning for 0 (`flag::zero_by_name`), such as a drive's
/// watchdog time. There any other way to write 0 is refused.
///
///     drive.write<zlac8015d::host_timeout>(undocumented_zero{});
struct undocumented_zero {};

namespace detail {
/// The range that values are checked against. It begins at 1 if 0 is written by name only.
constexpr range writable(range within, flag flags) {
    if (has(flags, flag::zero_by_name) && within.low == 0) within.low = 1;
    return within;
}

// Not constexpr on purpose: a constant that calls one does not compile. The error names the rule and, in the
// template arguments, the range.
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
    is_counted<typename row_type<R>::value_type>;

} // namespace detail

/// A value in counts of a register, or the error if the conversion is not exact.
struct counted {
    std::int64_t count;
    errc error;
};

/// Converts `value` to counts of register `R`; error `inexact` if it is not a whole number of them. The
/// register's range is not checked.
template <const auto& R, class V> constexpr counted count_of(V value) {
    using namespace detail;
    using T = typename row_type<R>::value_type;
    static_assert(!is_bool_or_character<V>, "a bool or a character is no number: give an integer");
    if constexpr (std::same_as<V, unit>) {
        static_assert(!std::same_as<V, unit>, "a unit is no value: 12.5 V is 125 * part<10>(volt)");
        return {};
    } else if constexpr (is_quantity<V>::value) {
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
        } else { // in 32 bits: a 64-bit division is expensive on a small core
            const std::int32_t whole =
                static_cast<std::int32_t>(value.count()) / static_cast<std::int32_t>(r.denominator);
            const bool exact = whole * static_cast<std::int32_t>(r.denominator) == value.count();
            return {whole * r.numerator, exact ? errc::ok : errc::inexact};
        }
    } else if constexpr (is_raw<V>::value) {
        return {widened(value.value), errc::ok};
    } else if constexpr (std::same_as<V, T> && !is_counted<T>) {
        return {std::int64_t{to_bits<T>(value)}, errc::ok};
    } else if constexpr (!std::integral<V> || !is_counted<T>) {
        static_assert(sizeof(V) == 0, "this register takes a value of its own type");
        return {};
    } else {
        static_assert(!has(R.flags, flag::scaled_elsewhere),
                      "another register rescales this one: write it through the drive, or by raw()");
        static_assert(takes_bare_numbers<R>, "this register is scaled: give a quantity, or a count by raw()");
        return {widened(value), errc::ok};
    }
}

namespace detail {
// The hook of registers/values.hpp.
template <class T> struct codec {
    static_assert(sizeof(T) == 0,
                  "floats, 64 bits, text and parts of a register: include servobus/any_value.hpp");
};
// A value that stores its words itself, by `store(frame, at, order)`: of registers/values.hpp.
template <class Value>
concept stores_words = requires {
    std::remove_cvref_t<Value>::needs_word_order;
};
/// True for a value whose words come in the device's order.
template <const auto& R> constexpr bool needs_word_order() {
    if constexpr (is_bit<R>)
        return false;
    else if constexpr (has_codec<typename row_type<R>::value_type>)
        return codec<typename row_type<R>::value_type>::needs_word_order;
    else
        return row_type<R>::words == 2;
}
/// True for a value that another row scales.
template <const auto& R> constexpr bool is_scaled() {
    if constexpr (has_codec<typename row_type<R>::value_type>)
        return codec<typename row_type<R>::value_type>::scale::exists;
    else
        return false;
}
// A concept: clang evaluates a bare constraint even when `register_value` is named with an array of
// registers.
template <const auto& R>
concept takes_undocumented_zero = has(R.flags, flag::zero_by_name);
} // namespace detail

/// A value to be written to register `R`, or the reason why it cannot be written.
template <const auto& R> class register_value {
    using row = row_type<R>;

  public:
    using value_type = typename row::value_type;
    static constexpr range writable = detail::writable(R.limits, R.flags);

    /// A constant. It does not compile if it is out of range, not a whole number of counts or of another kind
    /// than the register. A bool or a character does not compile in any of the constructors.
    template <class V> consteval register_value(V constant) { // NOLINT: implicit, `write<r>(500)`
        const counted c = count_of<R>(constant);
        if (c.error != errc::ok) detail::this_quantity_is_no_whole_number_of_the_register_s_counts();
        if (!writable.contains(c.count))
            detail::this_constant_is_outside_the_range_of_the_register<writable.low, writable.high>();
        bits_ = bits_of(c.count);
    }

    /// A run-time value; `error()` is `out_of_range` or `inexact` if it cannot be written.
    template <class V>
    constexpr register_value(checked_value<V> v) { // NOLINT: implicit, `write<r>(checked(v))`
        const counted c = count_of<R>(v.value);
        bits_ = bits_of(c.count);
        error_ = c.error != errc::ok ? c.error : writable.contains(c.count) ? errc::ok : errc::out_of_range;
    }

    /// A run-time value, limited to the range; `error()` is `inexact` if it is not a whole number of counts.
    template <class V>
    constexpr register_value(clamped_value<V> v) { // NOLINT: implicit, `write<r>(clamped(v))`
        const counted c = count_of<R>(v.value);
        error_ = c.error;
        bits_ = bits_of(c.count < writable.low    ? writable.low
                        : c.count > writable.high ? writable.high
                                                  : c.count);
    }

    /// The value 0 of a register with `flag::zero_by_name`.
    constexpr register_value(undocumented_zero) // NOLINT: implicit, `write<r>(undocumented_zero{})`
        requires detail::takes_undocumented_zero<R> {}

    /// `ok`, `out_of_range` or `inexact`; a value with an error is never sent.
    constexpr errc error() const { return error_; }
    /// The raw bits in two's complement; a register of one word uses the low half.
    constexpr u32 bits() const { return bits_; }

  private:
    static constexpr u32 bits_of(std::int64_t count) {
        return static_cast<u32>(static_cast<std::uint64_t>(count));
    }

    u32 bits_ = 0;
    errc error_ = errc::ok;

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(row::rights != access::ro, "this register is read-only");
};

namespace detail {
struct no_reading {}; // of an array, which is read by the element
} // namespace detail

/// Converts the raw bits of register `R` to the value that a read returns; see `reading`.
template <const auto& R> constexpr auto reading_of(u32 bits) {
    using T = typename row_type<R>::value_type;
    if constexpr (std::is_same_v<T, bool>) { // a coil or a discrete input
        return bits != 0;
    } else if constexpr (is_register_array<R>) {
        return detail::no_reading{}; // clang++ asks for it before it drops an overload for one row
    } else if constexpr (detail::has_codec<T>) {
        static_assert(!detail::is_scaled<R>(),
                      "another row scales this one: name both, read<power, power_exponent>()");
        return detail::codec<T>::template value_of<R>(bits);
    } else if constexpr (wire_integer<T> && R.unit_of_count.of != measure::none &&
                         !has(R.flags, flag::scaled_elsewhere)) {
        return quantity<R.unit_of_count, T>{from_bits<T>(bits)};
    } else if constexpr (wire_value<T>) {
        return from_bits<T>(bits);
    } else { // the row's own error is the only one
        return T{};
    }
}

/// The type that reading `R` returns: a quantity in the register's unit; for an enumeration or a packed word
/// the register's value type; an integer if there is no unit, or if another register sets the scale.
template <const auto& R> using reading = decltype(reading_of<R>(0));

/// The count of a reading, whatever its kind: what `raw` takes to write it to the register again. It is an integer
/// itself, the code of an enumeration, the word of a class that unpacks one, and 0 or 1 of a coil.
template <class T>
requires(detail::is_quantity<T>::value || std::same_as<T, bool> ||
         (std::integral<T> && !detail::is_bool_or_character<T>) || std::is_enum_v<T> ||
         packed_word<T>) constexpr auto count_of(const T& value) {
    if constexpr (detail::is_quantity<T>::value) {
        return value.count();
    } else if constexpr (packed_word<T>) {
        return value.to_word();
    } else if constexpr (std::is_enum_v<T>) {
        return static_cast<std::underlying_type_t<T>>(value);
    } else if constexpr (std::same_as<T, bool>) {
        return static_cast<u16>(value ? 1 : 0);
    } else {
        return value;
    }
}

} // namespace servobus
