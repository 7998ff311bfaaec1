// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The switches of a simulated drive by their names: a row for each member of its options.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "findings.hpp"

namespace tool {

/// A member of `Options`, a truth value or an enumeration whose first value is its default.
template <class Options> struct option_switch {
    interpretation what;
    void (*set)(Options&, unsigned way);
};

inline constexpr const char* no_or_yes[] = {"no", "yes"};
inline constexpr const char* yes_or_no[] = {"yes", "no"};

namespace detail {
template <class Options, class T> T member_type(T Options::*);
template <class Options, class T> Options class_of_member(T Options::*);
} // namespace detail

/// A row of a table of switches.
template <auto Member>
constexpr auto switched(const char* name, std::span<const char* const> ways, const char* place) {
    using options = decltype(detail::class_of_member(Member));
    using type = decltype(detail::member_type(Member));
    constexpr type standard = options{}.*Member;
    return option_switch<options>{{name, ways, place}, [](options& o, unsigned way) {
                                      if constexpr (std::is_same_v<type, bool>)
                                          o.*Member = standard != (way != 0);
                                      else
                                          o.*Member = static_cast<type>(way);
                                  }};
}
/// The same for a truth value.
template <auto Member> constexpr auto switched(const char* name, const char* place) {
    constexpr bool standard = decltype(detail::class_of_member(Member)){}.*Member;
    return switched<Member>(name, standard ? std::span<const char* const>{yes_or_no} : no_or_yes, place);
}

template <class Options, std::size_t N>
constexpr std::array<interpretation, N> interpretations_of(const option_switch<Options> (&table)[N]) {
    std::array<interpretation, N> all{};
    for (std::size_t i = 0; i < N; ++i) all[i] = table[i].what;
    return all;
}

/// The options for these ways; none: the simulator's own.
template <class Options, std::size_t N>
Options options_of(const option_switch<Options> (&table)[N], std::span<const unsigned> ways) {
    Options chosen{};
    for (std::size_t i = 0; i < ways.size() && i < N; ++i) table[i].set(chosen, ways[i]);
    return chosen;
}

} // namespace tool
