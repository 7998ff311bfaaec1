// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of the value types in registers/value_types.hpp: their readings, and the values that are written to them. The
// header of a device with such rows includes it; a program includes any_value.hpp.
//
//     inline constexpr reg<f32, access::rw, oven> target{0x0010, {-20, 400}, units::degree_celsius, 21};
//     constexpr register_value<target> warm = 215.5f; // 401 and a NaN do not compile
//     static_assert(warm.bits() == 0x43578000);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/detail/encode_number.hpp>
#include <servobus/registers/detail/value_codec.hpp>
#include <servobus/registers/tables.hpp>

namespace servobus {

namespace detail {
template <const auto& R>
concept has_coded_value = has_codec<typename std::remove_cvref_t<decltype(R)>::value_type>;
template <const auto& R>
concept has_text_value = coded_text<typename std::remove_cvref_t<decltype(R)>::value_type>;
} // namespace detail

/// A value to be written to register `R` of one of these types, or the reason why it cannot be written. A part of a
/// register is written by `change_bits<R>(value)`.
template <const auto& R>
requires(detail::has_coded_value<R> && !detail::has_text_value<R> &&
         !is_register_array<R>) class register_value<R> {
    using row = row_type<R>;
    using codec = detail::codec<typename row::value_type>;
    using number = typename codec::number;

  public:
    using value_type = typename row::value_type;

    /// A constant: a number, a quantity of the row's kind, or a code. It does not compile if it is out of range, not a
    /// whole number of counts, NaN or infinite.
    template <class V> consteval register_value(V constant) { // NOLINT: implicit, `write<r>(21.5f)`
        take(detail::encode<R, number>(constant, false));
        if (error_ == errc::inexact) detail::this_quantity_is_no_whole_number_of_the_register_s_counts();
        if (error_ == errc::out_of_range)
            detail::this_constant_is_outside_the_range_of_the_register<detail::limits_of<R>.low,
                                                                       detail::limits_of<R>.high>();
    }
    /// A run-time value; `error()` is `out_of_range` or `inexact` if it cannot be written.
    template <class V> constexpr register_value(checked_value<V> v) { // NOLINT: implicit
        take(detail::encode<R, number>(v.value, false));
    }
    /// A run-time value, limited to the range. `error()` is `inexact` if it is not a whole number of counts, and
    /// `out_of_range` for a NaN.
    template <class V> constexpr register_value(clamped_value<V> v) { // NOLINT: implicit
        take(detail::encode<R, number>(v.value, true));
    }

    /// `ok`, `out_of_range` or `inexact`; a value with an error is never sent.
    constexpr errc error() const { return error_; }
    static constexpr bool needs_word_order = codec::needs_word_order;
    static constexpr bool is_part = codec::options.bits != 0;
    /// The raw bits, high word first; those of a part at its place in the register.
    constexpr auto bits() const { return bits_; }
    /// Stores the words into a frame, from byte `at` on.
    constexpr void store(byte_buffer frame, std::size_t at, word_order of_device) const {
        detail::store_value<row::words>(frame, at, bits_, codec::order(of_device),
                                        codec::options.is_low_byte_first);
    }

  private:
    constexpr void take(detail::encoded<number> e) {
        error_ = e.error;
        if (error_ != errc::ok) return;
        const u64 raw = codec::raw_of(e.number);
        if (codec::type::is_none(raw >> codec::options.first_bit & codec::mask, codec::mask)) {
            error_ = errc::out_of_range; // it would mean "no value"
            return;
        }
        bits_ = static_cast<bits_type>(raw);
    }

    using bits_type = std::conditional_t<(row::words > 2), u64, u32>;
    bits_type bits_ = 0;
    errc error_ = errc::ok;

    // Last: clang++ has no member that follows a failed assertion, and would print an error for each that is used.
    static_assert(row::rights != access::ro, "this register is read-only");
};

/// Text to be written to register `R`, with zeros behind it.
template <const auto& R>
requires(detail::has_text_value<R> && !is_register_array<R>) class register_value<R> {
    using row = row_type<R>;
    using codec = detail::codec<typename row::value_type>;
    using text = typename codec::text;

  public:
    using value_type = typename row::value_type;

    /// A constant. One that is longer than the registers does not compile.
    template <std::size_t N>
    consteval register_value(const char (&constant)[N]) : text_{constant} {} // NOLINT: implicit
    constexpr register_value(const text& value) : text_{value} {}            // NOLINT: implicit
    /// A text of run time; `error()` is `out_of_range` if it is longer than the registers.
    constexpr register_value(checked_value<const char*> v) // NOLINT: implicit
        : error_{text_.assign(v.value) ? errc::ok : errc::out_of_range} {}

    constexpr errc error() const { return error_; }
    static constexpr bool needs_word_order = false;
    static constexpr bool is_part = false;
    /// Stores the words into a frame, from byte `at` on.
    constexpr void store(byte_buffer frame, std::size_t at, word_order) const {
        text_.store(frame, at, codec::is_low_byte_first);
    }

  private:
    text text_{};
    errc error_ = errc::ok;

    static_assert(row::rights != access::ro, "this register is read-only"); // last, as above
};

} // namespace servobus
