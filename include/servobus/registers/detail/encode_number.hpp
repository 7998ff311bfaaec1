// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A number that a program writes, in the type of a row's value: checked against the range, or limited to it.
// registers/values.hpp includes it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <servobus/registers/detail/value_codec.hpp>

namespace servobus::detail {

template <class V> struct is_real : std::false_type {};
template <unit U, class F> struct is_real<real<U, F>> : std::true_type {};

/// A number, or the reason why there is none.
template <class Number> struct encoded {
    Number number{};
    errc error = errc::ok;
};

// The limits of a row: those of its type if the manual states none.
template <const auto& R>
inline constexpr range
    limits_of = writable(R.limits.is_stated ? R.limits : full<typename row_type<R>::value_type>, R.flags);

template <const auto& R, class F> constexpr encoded<F> encode_float(F v, bool is_limited) {
    if (v != v) return {F{}, errc::out_of_range};
    constexpr F most = (std::numeric_limits<F>::max)();
    const F low = R.limits.is_stated ? static_cast<F>(R.limits.low) : -most;
    const F high = R.limits.is_stated ? static_cast<F>(R.limits.high) : most;
    if (v >= low && v <= high) return {v};
    if (!is_limited) return {F{}, errc::out_of_range};
    return {v < low ? low : high};
}

template <const auto& R, class Number>
constexpr encoded<Number> encode_count(std::int64_t count, bool is_limited) {
    constexpr range within = limits_of<R>;
    if (within.contains(count)) return {static_cast<Number>(count)};
    if (!is_limited) return {Number{}, errc::out_of_range};
    return {static_cast<Number>(count < within.low ? within.low : within.high)};
}

/// The integer in a number, in `raw`, or in a quantity.
template <class V> constexpr auto integer_in(V v) {
    if constexpr (is_raw<V>::value)
        return v.value;
    else if constexpr (is_quantity<V>::value)
        return v.count();
    else
        return v;
}
/// An integer, `raw` or a quantity as a number of row `R`. `count_of` limits counts to 64 bits with a sign: what is
/// beyond them is a number of a u64, or out of range.
template <const auto& R, class Number, class V>
constexpr encoded<Number> encode_integer(V v, bool is_limited) {
    constexpr std::int64_t most = highest<std::int64_t>;
    const counted c = count_of<R>(v);
    if (c.error != errc::ok) return {Number{}, c.error};
    constexpr ratio r = [] {
        if constexpr (is_quantity<V>::value)
            return conversion(V::unit_of_count, R.unit_of_count);
        else
            return ratio{};
    }();
    const auto integer = integer_in(v);
    bool is_beyond = false;
    if constexpr (std::is_same_v<decltype(integer), const u64>) {
        is_beyond = integer > static_cast<u64>(most);
        if constexpr (std::is_same_v<Number, u64> && r.numerator == r.denominator) {
            if (is_beyond && !R.limits.is_stated) return {integer};
        }
    }
    if constexpr (r.numerator != 1) {
        const std::int64_t whole = widened(integer) / r.denominator;
        is_beyond = is_beyond || whole > most / r.numerator || whole < -(most / r.numerator);
    }
    if (is_beyond && !is_limited) return {Number{}, errc::out_of_range};
    return encode_count<R, Number>(c.count, is_limited);
}

/// `v` as a number of row `R`.
template <const auto& R, class Number, class V> constexpr encoded<Number> encode(V v, bool is_limited) {
    using T = typename row_type<R>::value_type;
    if constexpr (codec<T>::is_enum) {
        static_assert(std::same_as<V, Number>, "this register takes a value of its own type");
        if constexpr (std::same_as<V, Number>) {
            const auto code = static_cast<std::int64_t>(static_cast<std::underlying_type_t<V>>(v));
            if (!limits_of<R>.contains(code)) return {Number{}, errc::out_of_range};
        }
        return {v};
    } else if constexpr (codec<T>::is_float && is_quantity<V>::value) {
        static_assert(same_kind(V::unit_of_count, R.unit_of_count),
                      "the quantity is of another kind than the register");
        constexpr ratio r = conversion(V::unit_of_count, R.unit_of_count);
        return encode_float<R>(static_cast<Number>(v.count()) * static_cast<Number>(r.numerator) /
                                   static_cast<Number>(r.denominator),
                               is_limited);
    } else if constexpr (codec<T>::is_float && is_real<V>::value) {
        return encode_float<R>(static_cast<Number>(v.in(unit_constant<R.unit_of_count>{})), is_limited);
    } else if constexpr (codec<T>::is_float) {
        static_assert(std::is_arithmetic_v<V> && !is_bool_or_character<V>,
                      "this register takes a number, or a quantity of its kind");
        if constexpr (sizeof(V) > sizeof(Number) && std::floating_point<V>) {
            // A double that no float holds must not be converted.
            constexpr V most = (std::numeric_limits<Number>::max)();
            if (v > most || v < -most)
                return encode_float<R>(v > 0 ? std::numeric_limits<Number>::infinity()
                                             : -std::numeric_limits<Number>::infinity(),
                                       is_limited);
        }
        return encode_float<R>(static_cast<Number>(v), is_limited);
    } else {
        static_assert(!codec<T>::scale::exists || is_raw<V>::value,
                      "another row scales this one: give a count by raw()");
        return encode_integer<R, Number>(v, is_limited);
    }
}

} // namespace servobus::detail
