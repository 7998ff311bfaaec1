// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table that the compiler makes of a server's rows, made at run time: random rows in the order of a pack, and what
// a plain search finds of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <servobus/server/detail/row_table.hpp>

#include <tests/support/served_rows.hpp>

namespace row_table_tests {

using namespace servobus;
using detail::plain_row;
using detail::pool;

namespace {

plain_row random_row(std::mt19937& random) {
    const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
    plain_row r;
    r.of = static_cast<table>(below(4));
    const bool is_bit = r.of <= table::discrete_inputs;
    const bool is_input = r.of == table::discrete_inputs || r.of == table::input_registers;
    r.rights = is_input ? servobus::access::ro : static_cast<servobus::access>(below(3));
    r.is_pair = !is_bit && below(3) == 0;
    r.in = is_bit ? pool::bits : r.is_pair ? pool::wide : pool::narrow;
    // Near both ends of the address space: tables follow each other there.
    const unsigned at = below(60);
    r.address = static_cast<u16>(at < 30 ? at : 0xFFFFu - (r.is_pair ? 1 : 0) - (at - 30));
    if (r.rights == servobus::access::ro && below(8) == 0) r.in = pool::functions;
    r.initial = below(1'000'000); // tells the rows apart
    return r;
}

unsigned words_of(const plain_row& r) { return r.is_pair ? 2 : 1; }
std::pair<table, unsigned> place_of(const plain_row& r) { return {r.of, r.address}; }

// The length of the longest run of numbers.
std::size_t longest_run(const std::set<unsigned>& all) {
    std::size_t longest = 0;
    for (const unsigned first : all) {
        std::size_t n = 0;
        while (all.count(first + static_cast<unsigned>(n)) != 0) ++n;
        longest = std::max(longest, n);
    }
    return longest;
}

template <std::size_t N>
void check_slots(const detail::row_list<N>& list, const std::vector<plain_row>& pack) {
    std::map<std::pair<pool, unsigned>, bool> slots; // true: writable
    for (std::size_t i = 0; i < N; ++i) {
        const plain_row& r = list.rows[i];
        REQUIRE(r.initial == pack[i].initial); // the order of the pack
        const bool is_new =
            slots.emplace(std::pair{r.in, unsigned{r.slot}}, r.rights != servobus::access::ro).second;
        REQUIRE(is_new);
        // Those of the same kind keep the order of the pack.
        for (std::size_t j = 0; j < i; ++j) {
            const plain_row& before = list.rows[j];
            if (before.in == r.in &&
                (before.rights == servobus::access::ro) == (r.rights == servobus::access::ro))
                REQUIRE(before.slot < r.slot);
        }
    }
    for (unsigned p = 0; p < detail::pools; ++p) {
        std::size_t places = 0;
        std::size_t writable = 0;
        for (const auto& [slot, is_writable] : slots) {
            if (slot.first != static_cast<pool>(p)) continue;
            ++places;
            if (is_writable) ++writable;
        }
        REQUIRE(list.places[p] == places);
        REQUIRE(list.ranges[p] == writable);
        for (const auto& [slot, is_writable] : slots) {
            if (slot.first == static_cast<pool>(p)) REQUIRE(is_writable == (slot.second < writable));
            if (slot.first == static_cast<pool>(p)) REQUIRE(slot.second < places);
        }
    }
}

template <std::size_t N> void check_order(const detail::row_list<N>& list, std::vector<plain_row> rows) {
    std::stable_sort(rows.begin(), rows.end(),
                     [](const plain_row& a, const plain_row& b) { return place_of(a) < place_of(b); });
    for (std::size_t i = 0; i < N; ++i) REQUIRE(list.rows[i].initial == rows[i].initial);
}

// Returns true if no rows share an address.
template <std::size_t N> bool check_runs(const detail::row_list<N>& list) {
    bool repeats = false;
    bool overlaps = false;
    std::set<unsigned> covered[4];
    std::set<unsigned> writable[4];
    std::set<std::pair<table, unsigned>> begins;
    bool can_read[4]{};
    bool can_write[4]{};
    for (const plain_row& r : list.rows) {
        repeats = !begins.insert(place_of(r)).second || repeats;
        const auto t = static_cast<std::size_t>(r.of);
        for (unsigned w = 0; w < words_of(r); ++w) {
            overlaps = !covered[t].insert(r.address + w).second || overlaps;
            if (r.rights != servobus::access::ro) writable[t].insert(r.address + w);
        }
        can_read[t] = can_read[t] || r.rights != servobus::access::wo;
        can_write[t] = can_write[t] || r.rights != servobus::access::ro;
    }
    REQUIRE(list.repeats == repeats);
    REQUIRE((list.repeats || list.overlaps) == overlaps);
    std::size_t first = 0;
    for (std::size_t t = 0; t < 4; ++t) {
        REQUIRE(list.first[t] == first);
        first += static_cast<std::size_t>(std::count_if(
            list.rows, list.rows + N, [&](const plain_row& r) { return r.of == static_cast<table>(t); }));
        REQUIRE(list.can_read[t] == can_read[t]);
        REQUIRE(list.can_write[t] == can_write[t]);
    }
    REQUIRE(list.first[4] == N);
    if (overlaps) return false; // such a table does not compile
    REQUIRE(list.longest_bits == std::max(longest_run(covered[0]), longest_run(covered[1])));
    REQUIRE(list.longest_run == std::max(longest_run(covered[2]), longest_run(covered[3])));
    REQUIRE(list.longest_write == longest_run(writable[2]));
    for (const plain_row& r : list.rows) {
        const auto& all = covered[static_cast<std::size_t>(r.of)];
        REQUIRE(r.ends_run == (all.count(r.address + words_of(r)) == 0));
    }
    return true;
}

template <std::size_t N> void check_tables(unsigned rounds) {
    CAPTURE(N);
    std::mt19937 random{static_cast<unsigned>(N)};
    unsigned sound = 0;
    for (unsigned round = 0; round < rounds; ++round) {
        CAPTURE(round);
        detail::row_list<N> list;
        std::vector<plain_row> pack;
        for (plain_row& r : list.rows) {
            r = random_row(random);
            pack.push_back(r);
        }
        detail::give_slots(list);
        check_slots(list, pack);
        detail::sort_rows(list);
        check_order(list, pack);
        detail::count_runs(list);
        if (check_runs(list)) ++sound;
    }
    CHECK(sound > rounds / 50);
}

} // namespace

TEST_CASE("rows of any order are sorted, and have slots, runs and ranges") {
    check_tables<1>(50);
    check_tables<2>(300);
    check_tables<3>(300);
    check_tables<8>(500);
    check_tables<13>(500);
    check_tables<16>(500);
}

TEST_CASE("a row is taken as it is described, and an array element by element") {
    detail::row_list<6> list;
    std::size_t at = 0;
    detail::append(list, at, served_rows::travel);
    detail::append(list, at, served_rows::lows);
    detail::append(list, at, servobus::computed<served_rows::ticks, served_rows::count_ticks>);
    detail::append(list, at, served_rows::is_primed);
    CHECK(at == 6);
    const plain_row& travel = list.rows[0];
    CHECK((travel.of == table::holding_registers && travel.in == pool::wide && travel.is_pair));
    CHECK((travel.address == 0x12 && travel.rights == servobus::access::rw));
    CHECK((travel.low == -5 && travel.high == 100'000 && travel.initial == -5));
    for (unsigned i = 0; i < 3; ++i) {
        const plain_row& low = list.rows[1 + i];
        CHECK((low.address == 0x17 + 2 * i && low.in == pool::narrow && !low.is_pair));
        CHECK((low.low == -100 && low.high == 100 && low.initial == -100));
    }
    CHECK((list.rows[4].in == pool::functions && list.rows[4].address == 0x14 && list.rows[4].is_pair));
    CHECK((list.rows[5].in == pool::bits && list.rows[5].of == table::coils && list.rows[5].initial == 1));
    // Without a default: 0, or the lowest value if 0 is out of range.
    CHECK(detail::plain(served_rows::command).initial == 0);
    CHECK(detail::plain(served_rows::highs[2]).initial == 100);
    // Equal classes have equal marks, which tell a row from another at its address.
    CHECK(list.rows[1].type == list.rows[3].type);
    CHECK(list.rows[1].type != list.rows[0].type);
}

} // namespace row_table_tests
