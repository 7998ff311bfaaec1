// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The options of a value type, collected: `options_of<with<i16, or_none<-1>>>`. registers/values.hpp includes it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/registers/reg.hpp>
#include <servobus/registers/value_types.hpp>

namespace servobus::detail {

struct value_options {
    unsigned first_bit = 0, bits = 0; // of a part of a register; 0: the whole
    std::int32_t offset = 0;
    word_order order = word_order::unknown; // of this row; unknown: that of the device
    bool is_low_byte_first = false;
};

/// The scale of a value by another row.
struct no_scale {
    static constexpr bool exists = false, is_exponent = false, is_optional = false;
    static constexpr std::int64_t none_now = 0;
};
template <const auto& Row, bool IsExponent> struct scale_by;

struct plain_option {
    using scale = no_scale;
    static constexpr bool is_option = true;
    static constexpr bool has_bits = true; // those of `bits` lie in a register
    static constexpr u64 first_none = 0;
    static constexpr bool has_none = false;
    static constexpr bool is_none(u64, u64) { return false; }
    static constexpr void add_to(value_options&) {}
};
/// The properties that one option adds. The primary template is for what is none.
template <class Option> struct value_option : plain_option { static constexpr bool is_option = false; };
template <unsigned First, unsigned Last> struct value_option<bits<First, Last>> : plain_option {
    static constexpr bool has_bits = First <= Last && Last <= 15;
    static constexpr void add_to(value_options& all) {
        all.first_bit = First;
        all.bits = Last - First + 1;
    }
};
template <std::int32_t Counts> struct value_option<offset<Counts>> : plain_option {
    static constexpr void add_to(value_options& all) { all.offset = Counts; }
};
template <std::int64_t... Codes> struct value_option<or_none<Codes...>> : plain_option {
    static constexpr bool has_none = true;
    static constexpr u64 first_none = [] {
        const std::int64_t all[] = {Codes...};
        return static_cast<u64>(all[0]);
    }();
    static constexpr bool is_none(u64 raw, u64 mask) {
        return ((raw == (static_cast<u64>(Codes) & mask)) || ...);
    }
};
template <const auto& Row> struct value_option<ten_to<Row>> : plain_option {
    using scale = scale_by<Row, true>;
};
template <const auto& Row> struct value_option<times_row<Row>> : plain_option {
    using scale = scale_by<Row, false>;
};
template <> struct value_option<high_word_first> : plain_option {
    static constexpr void add_to(value_options& all) { all.order = word_order::high_first; }
};
template <> struct value_option<low_word_first> : plain_option {
    static constexpr void add_to(value_options& all) { all.order = word_order::low_first; }
};
template <> struct value_option<low_byte_first> : plain_option {
    static constexpr void add_to(value_options& all) { all.is_low_byte_first = true; }
};

template <class... Scales> struct first_scale { using type = no_scale; };
template <class Scale, class... Others> struct first_scale<Scale, Others...> {
    using type = std::conditional_t<Scale::exists, Scale, typename first_scale<Others...>::type>;
};

/// A value type taken apart: its base, and its options.
template <class T> struct options_of {
    static constexpr void check() {}
    using base = T;
    using scale = no_scale;
    static constexpr value_options all{};
    static constexpr bool has_none = false;
    static constexpr bool is_none(u64, u64) { return false; }
};
template <class T, class... Options> struct options_of<with<T, Options...>> {
    // A function: clang++ would print errors for all members of a class with a failed assertion.
    static constexpr void check() {
        static_assert((value_option<Options>::is_option && ...),
                      "with<T, ...> takes bits, offset, or_none, ten_to, times_row, high_word_first, "
                      "low_word_first and low_byte_first");
        static_assert((value_option<Options>::has_bits && ...),
                      "bits<First, Last> are those of one register, from 0 to 15");
        static_assert(((value_option<Options>::has_none ? 1 : 0) + ... + 0) <= 1,
                      "one or_none has all codes");
        static_assert(((value_option<Options>::scale::exists ? 1 : 0) + ... + 0) <= 1,
                      "one row scales a value, by ten_to or times_row");
        static_assert(all.bits == 0 || !all.is_low_byte_first,
                      "bits<First, Last> names the bits as they come: low_byte_first is for whole registers");
        if constexpr (scale::exists) {
            static_assert(scale::is_integer,
                          "another row scales by an integer of one or two registers: u16, i16, u32, i32");
            static_assert(scale::is_plain, "the row that scales another has no scale of its own");
        }
    }
    using base = T;
    using scale = typename first_scale<typename value_option<Options>::scale...>::type;
    static constexpr value_options all = [] {
        value_options o;
        (value_option<Options>::add_to(o), ...);
        return o;
    }();
    static constexpr bool has_none = (value_option<Options>::has_none || ...);
    static constexpr u64 first_none = (value_option<Options>::first_none | ...);
    static constexpr bool is_none(u64 raw, u64 mask) {
        return (value_option<Options>::is_none(raw, mask) || ...);
    }
};

template <const auto& Row, bool IsExponent> struct scale_by {
    using options = options_of<typename row_type<Row>::value_type>;
    static constexpr bool exists = true, is_exponent = IsExponent;
    static constexpr bool is_optional = options::has_none; // then the value may be none too
    static constexpr std::int64_t none_now = lowest<std::int64_t>;
    static constexpr const auto& row = Row;
    static constexpr bool is_integer = wire_integer<typename options::base> && !options::scale::exists;
    static constexpr bool is_plain = Row.unit_of_count == unit{} || Row.unit_of_count == unit{measure::times};
};

} // namespace servobus::detail
