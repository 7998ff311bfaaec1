// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The entries of a plan, sorted by their kinds when it is compiled. Nothing here is recursive: the compiler's work and
// memory grow with the number of entries, and its limits for depth do not bound a plan.
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include <servobus/bus/plan_entries.hpp>

namespace servobus::detail {

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
inline constexpr std::size_t words_of_entry<cyclic_read<Rs...>> = request_of<Rs...>().words;

template <class T> inline constexpr bool is_of_other_table = false;
template <const auto&... Rs>
inline constexpr bool is_of_other_table<cyclic_read<Rs...>> = (needs_table_calls<Rs> || ...);

template <class T> inline constexpr bool has_pairs = false;
template <const auto&... Rs> inline constexpr bool has_pairs<cyclic_read<Rs...>> = readings<Rs...>::has_pairs;

template <class T> struct model_of_entry;
template <class Model> struct model_of_entry<controlled_drive<Model>> { using type = Model; };

/// Types by their numbers.
template <std::size_t I, class T> struct numbered { using type = T; };
template <class Numbers, class... Ts> struct numbered_types;
template <std::size_t... I, class... Ts>
struct numbered_types<std::index_sequence<I...>, Ts...> : numbered<I, Ts>... {};
template <std::size_t I, class T> numbered<I, T> find_number(const numbered<I, T>*);

/// The places of the entries of a kind among all, and how many words the reads before each have.
template <std::size_t N> struct places {
    std::size_t place[N == 0 ? 1 : N]{};
    std::size_t words_before[N == 0 ? 1 : N]{};
};

// No fold expressions: clang++ takes at most 256 entries in one.
template <class... Entries> struct entry_list {
    static constexpr std::size_t count(const bool (&kinds)[sizeof...(Entries) + 1]) {
        std::size_t n = 0;
        for (const bool is_of_kind : kinds) n += is_of_kind ? 1u : 0u;
        return n;
    }
    static constexpr bool read_kinds[sizeof...(Entries) + 1] = {is_read<Entries>..., false};
    static constexpr bool drive_kinds[sizeof...(Entries) + 1] = {is_controlled<Entries>..., false};
    static constexpr std::size_t words_of[sizeof...(Entries) + 1] = {words_of_entry<Entries>..., 0};
    static constexpr bool are_entries = count({!is_entry<Entries>..., false}) == 0;
    static constexpr std::size_t reads = count(read_kinds);
    static constexpr std::size_t drives = count(drive_kinds);
    static constexpr std::size_t requested = count({is_requested<Entries>..., false});
    static constexpr std::size_t rules = count({std::is_same_v<Entries, back_off>..., false});
    static constexpr std::size_t reads_of_other_tables = count({is_of_other_table<Entries>..., false});
    static constexpr std::size_t reads_with_pairs = count({has_pairs<Entries>..., false});
    static constexpr std::size_t words = [] {
        std::size_t sum = 0;
        for (const std::size_t own : words_of) sum += own;
        return sum;
    }();
    static constexpr std::size_t longest_response = [] {
        std::size_t longest = 0;
        for (const std::size_t own : words_of) longest = own > longest ? own : longest;
        return 5 + 2 * longest;
    }();

    template <std::size_t N> static constexpr places<N> find(const bool (&kinds)[sizeof...(Entries) + 1]) {
        places<N> found{};
        std::size_t n = 0;
        std::size_t before = 0;
        for (std::size_t i = 0; i < sizeof...(Entries); ++i) {
            if (kinds[i]) {
                found.place[n] = i;
                found.words_before[n++] = before;
            }
            before += words_of[i];
        }
        return found;
    }
    static constexpr places<reads> of_reads = find<reads>(read_kinds);
    static constexpr places<drives> of_drives = find<drives>(drive_kinds);

    using all = numbered_types<std::index_sequence_for<Entries...>, Entries...>;
    template <std::size_t Place>
    using at = typename decltype(find_number<Place>(static_cast<const all*>(nullptr)))::type;
    template <std::size_t I> using drive = typename model_of_entry<at<of_drives.place[I]>>::type;
};

} // namespace servobus::detail
