// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A value of registers/values.hpp that a device stores in one of its own registers: a float, decimal digits, a number
// with an offset, or none. Servers that have such rows include it.
//
//     row_values<sdm120::voltage> values;
//     values.set<sdm120::voltage>(measured); // a float of run time; a NaN means "no value"
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/values.hpp>
#include <servobus/server/stored_value.hpp>

namespace servobus {

namespace detail {
/// The raw bits of what a read returned.
template <class Codec, class T> constexpr u32 bits_of_value(const T& v) {
    if constexpr (is_real<T>::value)
        return v.bits();
    else if constexpr (is_quantity<T>::value)
        return static_cast<u32>(Codec::raw_of(v.count()));
    else
        return static_cast<u32>(Codec::raw_of(v));
}
template <class Codec, class V> constexpr u32 bits_of_value(const maybe<V>& v) {
    if (v) return bits_of_value<Codec>(*v);
    if constexpr (Codec::type::has_none)
        return static_cast<u32>(Codec::type::first_none & Codec::mask);
    else
        return static_cast<u32>(Codec::mask); // of decimal digits: Fh is none
}
} // namespace detail

/// A value of row `R` in the server's registers.
template <const auto& R>
requires(detail::has_coded_value<R> && !is_register_array<R>) class stored_value<R> {
    using codec = detail::codec<typename row_type<R>::value_type>;
    using number = typename codec::number;

    // Values of run time need a row that takes each of them.
    static constexpr bool is_free = !R.limits.is_stated;
    template <class V>
    static constexpr bool is_run_time_float =
        codec::is_float&& is_free&& std::same_as<V, typename codec::base>;
    template <class V>
    static constexpr bool is_run_time = is_run_time_float<V> || (is_free && std::same_as<V, reading<R>>);

  public:
    using value_type = typename row_type<R>::value_type;

    /// A constant: a number, a quantity of the row's kind, or a code. One that is out of range, or no whole number of
    /// counts, does not compile.
    template <class V>
    requires(!is_run_time<V>) consteval stored_value(V constant) { // NOLINT: implicit
        const detail::encoded<number> e = encoded(constant);
        if (e.error == errc::inexact) detail::this_quantity_is_no_whole_number_of_the_register_s_counts();
        if (e.error == errc::out_of_range)
            detail::this_constant_is_outside_the_range_of_the_register<detail::limits_of<R>.low,
                                                                       detail::limits_of<R>.high>();
        bits_ = bits_of(e.number);
    }
    /// A run-time value of a row without a stated range, as a read returns it. A NaN means "no value", and so does a
    /// `maybe` that has none.
    constexpr stored_value(reading<R> v) // NOLINT: implicit
        requires(!R.limits.is_stated)
        : bits_{detail::bits_of_value<codec>(v)} {}
    /// A float of run time, of a row without a stated range.
    template <class F>
    requires is_run_time_float<F>
    constexpr stored_value(F v) : bits_{bits_of(v)} {} // NOLINT: implicit
    /// A run-time value, limited to the range. A NaN means "no value".
    template <class V> constexpr stored_value(clamped_value<V> v) { // NOLINT: implicit
        const detail::encoded<number> e = detail::encode<R, number>(v.value, true);
        bits_ = codec::is_float && e.error != errc::ok ? u32{0x7FC0'0000} : bits_of(e.number);
    }

    constexpr u32 bits() const { return bits_; }
    static constexpr u32 bits_of_reading(reading<R> v) { return detail::bits_of_value<codec>(v); }
    /// A value as `set(checked(v))` stores it, or the reason why it does not.
    template <class V> static constexpr detail::encoded<number> encoded(V v) {
        return detail::encode<R, number>(v, false);
    }
    static constexpr u32 bits_of(number v) { return static_cast<u32>(codec::raw_of(v)); }

  private:
    u32 bits_ = 0;
};

} // namespace servobus
