// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The entries of a plan, sorted by their kinds when it is compiled.
#pragma once

#include <cstddef>
#include <type_traits>

#include <servobus/bus/plan_entries.hpp>

namespace servobus::detail {

/// Types in their order.
template <class... Ts> struct types {};
template <class Types, class T> struct appended;
template <class... Ts, class T> struct appended<types<Ts...>, T> { using type = types<Ts..., T>; };
template <std::size_t I, class Types> struct nth;
template <class First, class... More> struct nth<0, types<First, More...>> { using type = First; };
template <std::size_t I, class First, class... More>
struct nth<I, types<First, More...>> : nth<I - 1, types<More...>> {};

template <class Reads, class Models, class... Left> struct sorted {
    using reads = Reads;
    using models = Models;
};
template <class Reads, class Models, const auto&... Rs, class... Left>
struct sorted<Reads, Models, cyclic_read<Rs...>, Left...>
    : sorted<typename appended<Reads, cyclic_read<Rs...>>::type, Models, Left...> {};
template <class Reads, class Models, class Model, class... Left>
struct sorted<Reads, Models, controlled_drive<Model>, Left...>
    : sorted<Reads, typename appended<Models, Model>::type, Left...> {};
template <class Reads, class Models, class... Left>
struct sorted<Reads, Models, requested_node, Left...> : sorted<Reads, Models, Left...> {};
template <class Reads, class Models, class... Left>
struct sorted<Reads, Models, back_off, Left...> : sorted<Reads, Models, Left...> {};

template <class T> inline constexpr bool is_read = false;
template <const auto&... Rs> inline constexpr bool is_read<cyclic_read<Rs...>> = true;
template <class T> inline constexpr bool is_controlled = false;
template <class Model> inline constexpr bool is_controlled<controlled_drive<Model>> = true;
template <class T> inline constexpr bool is_requested = std::is_same_v<T, requested_node>;
template <class T>
inline constexpr bool is_entry =
    is_read<T> || is_controlled<T> || is_requested<T> || std::is_same_v<T, back_off>;

template <class T> inline constexpr std::size_t words_of_entry = 0;
template <const auto&... Rs>
inline constexpr std::size_t words_of_entry<cyclic_read<Rs...>> = readings<Rs...>::plan.words;

template <class... Entries> struct entry_list {
    static constexpr std::size_t reads = (std::size_t{0} + ... + (is_read<Entries> ? 1u : 0u));
    static constexpr std::size_t drives = (std::size_t{0} + ... + (is_controlled<Entries> ? 1u : 0u));
    static constexpr std::size_t requested = (std::size_t{0} + ... + (is_requested<Entries> ? 1u : 0u));
    static constexpr std::size_t rules =
        (std::size_t{0} + ... + (std::is_same_v<Entries, back_off> ? 1u : 0u));
    static constexpr std::size_t words = (std::size_t{0} + ... + words_of_entry<Entries>);
    static constexpr std::size_t longest_response = [] {
        std::size_t longest = 0;
        for (const std::size_t own : {std::size_t{0}, words_of_entry<Entries>...})
            longest = own > longest ? own : longest;
        return 5 + 2 * longest;
    }();
    template <std::size_t I>
    using read = typename nth<I, typename sorted<types<>, types<>, Entries...>::reads>::type;
    template <std::size_t I>
    using drive = typename nth<I, typename sorted<types<>, types<>, Entries...>::models>::type;
};

} // namespace servobus::detail
