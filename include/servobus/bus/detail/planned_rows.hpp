// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Finds the rows of a plan's cyclic reads when the program is compiled, for `latest<row>(node, ..)`. bus.hpp includes
// it. The rows of all reads are listed once, and the reads of a node are chained. So the compiler's work for a row
// grows with the reads of its node alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/bus/plan.hpp>
#include <servobus/bus/plan_entries.hpp>
#include <servobus/client/node.hpp>

namespace servobus::detail {

// Not constexpr on purpose: a program that calls one does not compile, and the error names the rule.
inline void the_plan_does_not_read_this_row_of_this_node() {}
inline void no_cyclic_read_of_the_plan_has_all_these_rows_of_this_node() {}

/// A row among others: two with one class and one address are the same. The class has its name, since the addresses of
/// two objects are no constants to compare for g++ 11.
struct row_key {
    const char* of_class = nullptr;
    std::uint16_t address = 0;

    constexpr bool operator==(const row_key& other) const {
        return address == other.address && __builtin_strcmp(of_class, other.of_class) == 0;
    }
};
template <class Row> constexpr const char* name_of_class() { return __PRETTY_FUNCTION__; }
template <const auto& R> inline constexpr row_key key_of{name_of_class<row_type<R>>(), R.address};

/// The rows of an entry of a plan.
struct row_keys {
    const row_key* keys = nullptr;
    std::size_t size = 0;

    constexpr bool has(const row_key& wanted) const {
        for (std::size_t i = 0; i < size; ++i) {
            if (keys[i] == wanted) return true;
        }
        return false;
    }
};
template <const auto&... Rs> inline constexpr row_key keys_of[sizeof...(Rs)] = {key_of<Rs>...};
template <class Entry> inline constexpr row_keys keys_of_entry{};
template <const auto&... Rs>
inline constexpr row_keys keys_of_entry<cyclic_read<Rs...>>{keys_of<Rs...>, sizeof...(Rs)};
template <class Plan> struct keys_of_entries;
template <class... Entries> struct keys_of_entries<poll_plan<Entries...>> {
    static constexpr row_keys of[sizeof...(Entries)] = {keys_of_entry<Entries>...};
};

/// The reads of a plan by their nodes.
template <std::size_t Size> struct reads_by_node {
    static constexpr std::size_t none = Size;

    std::size_t first[256]{};                 // of a node
    std::size_t next[Size == 0 ? 1 : Size]{}; // of the same node

    constexpr explicit reads_by_node(const poll* polls) {
        for (std::size_t& read : first) read = none;
        for (std::size_t i = Size; i-- != 0;) {
            next[i] = first[polls[i].node_address];
            first[polls[i].node_address] = i;
        }
    }
};
template <const auto& Plan>
inline constexpr reads_by_node<Plan.size> reads_of_nodes{static_cast<const poll*>(Plan.polls)};

/// Where a bus keeps the values of rows.
struct place_of_rows {
    std::size_t read = 0;   ///< the number of the cyclic read
    std::size_t offset = 0; ///< of the first row among the words, or the bits, of all reads
};

/// A search for the cyclic read that has all of `Rs`. If there are several, the one with the shortest period counts.
template <const auto& Plan, const auto&... Rs> struct search_for_rows {
    using plan_type = std::remove_cvref_t<decltype(Plan)>;

    place_of_rows found{};
    std::size_t nodes = 0;

    constexpr explicit search_for_rows(std::uint8_t node_address) { search(node_address); }
    constexpr search_for_rows() {
        for (unsigned node_address = 0; node_address < 256; ++node_address)
            search(static_cast<std::uint8_t>(node_address));
    }

  private:
    static constexpr bool has_all(std::size_t read) {
        const row_keys& own = keys_of_entries<plan_type>::of[plan_type::offsets.place[read]];
        return (own.has(key_of<Rs>) && ...);
    }
    // A read of the node, if it has them.
    constexpr void search(std::uint8_t node_address) {
        constexpr const auto& reads = reads_of_nodes<Plan>;
        std::size_t best = reads.none;
        for (std::size_t i = reads.first[node_address]; i != reads.none; i = reads.next[i]) {
            const bool is_better = best == reads.none || Plan.polls[i].period < Plan.polls[best].period;
            if (is_better && has_all(i)) best = i;
        }
        if (best == reads.none) return;
        ++nodes;
        std::uint16_t lowest = 0xFFFF;
        ((lowest = Rs.address < lowest ? Rs.address : lowest), ...);
        const std::size_t words_before = plan_type::offsets.words_before[best];
        const std::size_t after_the_first = lowest - std::size_t{Plan.polls[best].address};
        found = {best, (has_bits(best) ? 16 * words_before : words_before) + after_the_first};
    }
    static constexpr bool has_bits(std::size_t read) { return Plan.polls[read].code <= 0x02; }
};

/// A constant node with a row that the plan reads of it. The place is no base: clang++ 14 crashes with one.
template <const auto& Plan, const auto& R> struct row_that_the_plan_reads_of_this_node {
    place_of_rows place;

    template <device_class Device>
    consteval row_that_the_plan_reads_of_this_node(const node<Device>& of) { // NOLINT: implicit
        static_assert(belongs_to<typename row_type<R>::device, Device>,
                      "this register belongs to another device");
        const search_for_rows<Plan, R> all{of.address};
        if (all.nodes == 0) the_plan_does_not_read_this_row_of_this_node();
        place = all.found;
    }
};
/// A constant node with rows that one cyclic read of the plan has of it.
template <const auto& Plan, const auto&... Rs> struct rows_that_one_cyclic_read_has_of_this_node {
    place_of_rows place;

    template <device_class Device>
    consteval rows_that_one_cyclic_read_has_of_this_node(const node<Device>& of) { // NOLINT: implicit
        static_assert((belongs_to<typename row_type<Rs>::device, Device> && ...),
                      "this register belongs to another device");
        const search_for_rows<Plan, Rs...> all{of.address};
        if (all.nodes == 0) no_cyclic_read_of_the_plan_has_all_these_rows_of_this_node();
        place = all.found;
    }
};

/// The place of rows of the only node from which the plan reads them.
template <const auto& Plan, const auto&... Rs> consteval place_of_rows place_at_the_only_node() {
    constexpr search_for_rows<Plan, Rs...> all{};
    static_assert(sizeof...(Rs) != 1 || all.nodes != 0, "the plan has no cyclic read of this row");
    static_assert(sizeof...(Rs) == 1 || all.nodes != 0,
                  "no cyclic read of the plan has all these rows: rows of several reads are not of one "
                  "moment");
    static_assert(all.nodes <= 1,
                  "the plan reads this of several nodes, so a node is named: latest<row>(node, oldest)");
    return all.found;
}

} // namespace servobus::detail
