// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The types of registers/values.hpp in catalogues: `list` takes kind and form of an entry from the row's type. The
// catalogues of devices that have such rows include it, and so do tools.
//
//     inline constexpr entry table[]{list("power", power), list("hour", hour)}; // rows of a f32 and of a high byte
//     static_assert(table[0].kind == value_kind::float_pair && table[1].form->mask() == 0xFF00);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>
#include <span>
#include <type_traits>

#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/values.hpp>

namespace servobus::detail {

template <> inline constexpr value_kind kind_of_coded<u64> = value_kind::unsigned_quad;
template <> inline constexpr value_kind kind_of_coded<i64> = value_kind::signed_quad;
template <> inline constexpr value_kind kind_of_coded<f32> = value_kind::float_pair;
template <> inline constexpr value_kind kind_of_coded<f64> = value_kind::float_quad;
template <> inline constexpr value_kind kind_of_coded<bcd<1>> = value_kind::bcd_word;
template <> inline constexpr value_kind kind_of_coded<bcd<2>> = value_kind::bcd_pair;
template <> inline constexpr value_kind kind_of_coded<sign_magnitude<1>> = value_kind::sign_magnitude_word;
template <> inline constexpr value_kind kind_of_coded<sign_magnitude<2>> = value_kind::sign_magnitude_pair;
template <class T>
requires std::is_enum_v<T>
inline constexpr value_kind kind_of_coded<T> = value_kind::unsigned_pair;
template <std::size_t N> inline constexpr value_kind kind_of_coded<text_of<N>> = value_kind::text;
template <class T, class... Options>
inline constexpr value_kind kind_of_coded<with<T, Options...>> = kind_of<T>();

/// The codes that mean "no value", among the options of a value type.
template <class Option> inline constexpr std::span<const std::int64_t> codes_of_option{};
template <std::int64_t... Codes> inline constexpr std::int64_t kept_codes[] = {Codes...};
template <std::int64_t... Codes>
inline constexpr std::span<const std::int64_t> codes_of_option<or_none<Codes...>>{kept_codes<Codes...>};
template <class T> inline constexpr std::span<const std::int64_t> codes_of_type{};
template <class T, class... Options>
inline constexpr std::span<const std::int64_t> codes_of_type<with<T, Options...>> = [] {
    std::span<const std::int64_t> all{};
    ((all = codes_of_option<Options>.empty() ? all : codes_of_option<Options>), ...);
    return all;
}();

template <class T>
inline constexpr value_form kept_form = [] {
    using type = options_of<T>;
    value_form f;
    if constexpr (is_text_type<typename type::base>) f.words = static_cast<std::uint8_t>(words_in<T>);
    f.first_bit = static_cast<std::uint8_t>(type::all.first_bit);
    f.bits = static_cast<std::uint8_t>(type::all.bits);
    f.is_low_byte_first = type::all.is_low_byte_first;
    f.offset = type::all.offset;
    f.none = codes_of_type<T>;
    if constexpr (type::scale::exists) {
        f.scaled = type::scale::is_exponent ? scaling::exponent : scaling::factor;
        f.scale_table = table_of<type::scale::row>;
        f.scale_address = type::scale::row.address;
    }
    return f;
}();

/// The form of a type; null if the kind says all.
template <class T> constexpr const value_form* form_of_coded() {
    constexpr bool is_plain = std::is_same_v<typename options_of<T>::base, T> && !is_text_type<T>;
    if constexpr (is_plain)
        return nullptr;
    else
        return &kept_form<T>;
}

template <class T>
requires has_codec<T>
struct form_of<T> {
    static constexpr value_kind kind = kind_of_coded<T>;
    static constexpr const value_form* form = form_of_coded<T>();
    static constexpr word_order own_word_order = options_of<T>::all.order;
};

} // namespace servobus::detail
