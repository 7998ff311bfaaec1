// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The codec of each value type: its words, its limits, and its value of a row. registers/values.hpp includes it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/registers/decimal.hpp>
#include <servobus/registers/detail/number_format.hpp>
#include <servobus/registers/detail/value_options.hpp>
#include <servobus/registers/maybe.hpp>
#include <servobus/registers/real.hpp>
#include <servobus/registers/register_value.hpp>
#include <servobus/registers/text_value.hpp>

namespace servobus {

namespace detail {

template <> inline constexpr std::size_t words_in<u64> = 4;
template <> inline constexpr std::size_t words_in<i64> = 4;
template <> inline constexpr std::size_t words_in<f32> = 2;
template <> inline constexpr std::size_t words_in<f64> = 4;
template <class T>
requires(std::is_enum_v<T> && sizeof(T) == 4) inline constexpr std::size_t words_in<T> = 2;
template <std::size_t N> inline constexpr std::size_t words_in<bcd<N>> = N;
template <std::size_t N> inline constexpr std::size_t words_in<sign_magnitude<N>> = N;
template <std::size_t N> inline constexpr std::size_t words_in<text_of<N>> = N;
template <class T, class... Options> inline constexpr std::size_t words_in<with<T, Options...>> = words_in<T>;

template <> inline constexpr bool has_codec<u64> = true;
template <> inline constexpr bool has_codec<i64> = true;
template <> inline constexpr bool has_codec<f32> = true;
template <> inline constexpr bool has_codec<f64> = true;
template <class T>
requires(std::is_enum_v<T> && sizeof(T) == 4) inline constexpr bool has_codec<T> = true;
template <std::size_t N> inline constexpr bool has_codec<bcd<N>> = true;
template <std::size_t N> inline constexpr bool has_codec<sign_magnitude<N>> = true;
template <std::size_t N> inline constexpr bool has_codec<text_of<N>> = true;
template <class T, class... Options> inline constexpr bool has_codec<with<T, Options...>> = true;

template <> inline constexpr bool is_counted<u64> = true;
template <> inline constexpr bool is_counted<i64> = true;
template <std::size_t N> inline constexpr bool is_counted<bcd<N>> = true;
template <std::size_t N> inline constexpr bool is_counted<sign_magnitude<N>> = true;
template <class T, class... Options> inline constexpr bool is_counted<with<T, Options...>> = is_counted<T>;

template <class T> inline constexpr bool is_text_type = false;
template <std::size_t N> inline constexpr bool is_text_type<text_of<N>> = true;

template <> inline constexpr bool takes_words<u64> = true;
template <> inline constexpr bool takes_words<i64> = true;
template <> inline constexpr bool takes_words<f64> = true;
template <std::size_t N> inline constexpr bool takes_words<text_of<N>> = true;
template <class T, class... Options>
inline constexpr bool takes_words<with<T, Options...>> = [] {
    using type = options_of<with<T, Options...>>;
    constexpr value_options o = type::all;
    return words_in<T> > 2 || is_text_type<T> || o.bits != 0 || o.order != word_order::unknown ||
           o.is_low_byte_first || type::scale::exists;
}();
template <class T, class... Options>
inline constexpr bool is_part<with<T, Options...>> = options_of<with<T, Options...>>::all.bits != 0;

template <class T>
concept coded_text = has_codec<T> && is_text_type<typename options_of<T>::base>;

/// The codec of numbers.
template <class T>
requires(has_codec<T> && !coded_text<T>) struct codec<T> {
    using type = options_of<T>;
    using base = typename type::base;
    using format = number_format<base>;
    using scale = typename type::scale;

    static constexpr std::size_t words = words_in<T>;
    static constexpr value_options options = type::all;
    static constexpr unsigned width = options.bits != 0 ? options.bits : 16 * words;
    static constexpr u64 mask = bits_below(width);
    static constexpr bool is_float = std::is_floating_point_v<base>;
    static constexpr bool is_enum = std::is_enum_v<base>;
    static constexpr bool needs_word_order = words > 1 && options.order == word_order::unknown;
    /// True if raw bits, as integers of the base, have the order of the numbers.
    static constexpr bool is_in_order = wire_integer<base>;

    /// Refuses options that contradict each other.
    static constexpr void check() {
        type::check();
        static_assert(is_float || is_enum || wire_integer<base> || has_codec<base>,
                      "with<T, ...> is for a number, an enumeration or a text");
        static_assert(options.bits == 0 || words == 1, "bits<First, Last> are those of one register");
        static_assert(options.offset == 0 || (words <= 2 && !is_float && !is_enum),
                      "an offset is added to an integer of one or two registers");
        static_assert(!scale::exists || (!is_float && !is_enum),
                      "another row scales an integer: the program scales a float");
        static_assert(options.offset >= -0x7FFE'0000 && options.offset <= 0x7FFE'0000,
                      "an offset is at most 2147352576");
    }

    /// 32 bits if all numbers fit, so that a small core does not calculate with 64.
    using number = std::conditional_t<options.offset == 0, typename format::number,
                                      std::conditional_t<words == 1, std::int32_t, std::int64_t>>;

    static constexpr number number_of(u64 raw) {
        if constexpr (options.offset == 0)
            return format::from(raw, width);
        else
            return static_cast<number>(static_cast<number>(format::from(raw, width)) + options.offset);
    }
    /// The bits of the register, or of all words; those of a part lie at its place.
    static constexpr u64 raw_of(number v) {
        if constexpr (options.offset == 0)
            return (format::to(v) & mask) << options.first_bit;
        else
            return (format::to(static_cast<typename format::number>(v - options.offset)) & mask)
                   << options.first_bit;
    }
    static constexpr number_range limits() {
        number_range r = format::limits(width);
        r.low += options.offset;
        r.high += options.offset;
        return r;
    }

    /// The value of row `R`. `by`: the exponent or the factor, where another row scales it.
    template <const auto& R> static constexpr auto value_of(u64 bits, std::int64_t by = 0) {
        const u64 raw = bits >> options.first_bit & mask;
        constexpr bool is_bcd = requires { typename format::has_wrong_digits; };
        if constexpr (type::has_none || scale::is_exponent || scale::is_optional || is_bcd) {
            using value = decltype(plain_value_of<R>(raw, by));
            const bool is_none = type::is_none(raw, mask) || !format::is_number(raw, width) ||
                                 (scale::is_exponent && (by < -10 || by > 10)) ||
                                 (scale::is_optional && by == scale::none_now);
            return is_none ? maybe<value>{} : maybe<value>{plain_value_of<R>(raw, by)};
        } else {
            return plain_value_of<R>(raw, by);
        }
    }
    /// The value of row `R` whose words are `word_at(0)`, `word_at(1)` and so on.
    template <const auto& R, class WordAt>
    static constexpr auto value_in(const WordAt& word_at, word_order of_device, std::int64_t by = 0) {
        return value_of<R>(join_value<words>(word_at, order(of_device), options.is_low_byte_first), by);
    }
    static constexpr word_order order(word_order of_device) {
        return options.order == word_order::unknown ? of_device : options.order;
    }

  private:
    template <const auto& R> static constexpr auto plain_value_of(u64 raw, [[maybe_unused]] std::int64_t by) {
        const number n = number_of(raw);
        if constexpr (scale::exists) {
            if constexpr (!scale::is_exponent)
                return quantity<R.unit_of_count, std::int64_t>{limited_product(widened(n), by)};
            else if constexpr (std::is_same_v<number, u64>)
                return servobus::decimal<R.unit_of_count>::of_unsigned(n, static_cast<int>(by));
            else
                return servobus::decimal<R.unit_of_count>{n, static_cast<int>(by)};
        } else if constexpr (is_float) {
            return real<R.unit_of_count, base>::from_bits(static_cast<typename format::raw_type>(raw));
        } else if constexpr (!is_enum && R.unit_of_count.of != measure::none &&
                             !has(R.flags, flag::scaled_elsewhere)) {
            return quantity<R.unit_of_count, number>{n};
        } else {
            return n;
        }
    }
};

/// The codec of text.
template <coded_text T> struct codec<T> {
    using type = options_of<T>;
    using text = typename type::base;
    using scale = no_scale;
    static constexpr std::size_t words = words_in<T>;
    static constexpr bool is_low_byte_first = type::all.is_low_byte_first;
    static constexpr bool needs_word_order = false;
    static constexpr void check() {
        type::check();
        static_assert(type::all.bits == 0 && type::all.offset == 0 && !type::has_none &&
                          !type::scale::exists && type::all.order == word_order::unknown,
                      "a text has one option, low_byte_first");
    }

    static constexpr number_range limits() { return {0, 0}; }
    template <const auto& R> static constexpr text value_of(u64) { return {}; } // for its type
    template <const auto& R, class WordAt> static constexpr text value_in(const WordAt& word_at, word_order) {
        return text::from(word_at, is_low_byte_first);
    }
};

template <class T>
requires has_codec<T>
inline constexpr shape shape_of<T>{codec<T>::limits().low, codec<T>::limits().high,
                                   static_cast<std::uint8_t>(words_in<T>)};

} // namespace detail

/// The range of such a value's type, for registers without a stated range.
template <class T>
requires detail::has_codec<T>
inline constexpr range full<T>{detail::shape_of<T>.low, detail::shape_of<T>.high, false};

} // namespace servobus
