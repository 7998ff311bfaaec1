// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads of rows of several tables, planned at run time: random rows, and what a plain count of their addresses demands.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <utility>

#include <servobus/registers/tables.hpp>

namespace table_plans_tests {

using namespace servobus;
using detail::table_row;

namespace {
using places = std::multiset<std::pair<table, unsigned>>; // each bit or word

void add(places& all, table of, unsigned address, unsigned quantity) {
    for (unsigned i = 0; i < quantity; ++i) all.insert({of, address + i});
}
std::size_t bytes_of(const table_extent& e) {
    return e.of == table::coils || e.of == table::discrete_inputs ? (e.quantity + 7u) / 8u : 2u * e.quantity;
}

template <std::size_t N> void check_plans(unsigned rounds) {
    CAPTURE(N);
    std::mt19937 random{static_cast<unsigned>(N)};
    const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
    unsigned sound = 0;
    unsigned split = 0;
    for (unsigned round = 0; round < rounds; ++round) {
        CAPTURE(round);
        const auto most = static_cast<u16>(2 + below(6));
        table_row rows[N];
        places wanted;
        for (table_row& r : rows) {
            r.of = static_cast<table>(below(4));
            const bool is_bit = r.of == table::coils || r.of == table::discrete_inputs;
            r.quantity = static_cast<u16>(is_bit ? 1 : 1 + below(2));
            r.address = static_cast<u16>((below(2) == 0 ? 0x0300 : 0xFFF0) + below(14));
            add(wanted, r.of, r.address, r.quantity);
        }
        table_row given[N];
        std::copy(rows, rows + N, given);
        const detail::table_plan<N> p = detail::plan_tables<N>(std::move(given), most);

        const bool overlaps = std::set(wanted.begin(), wanted.end()).size() != wanted.size();
        REQUIRE(p.overlaps == overlaps);
        if (overlaps) continue; // such a read does not compile
        ++sound;
        places read;
        std::size_t offset = 0;
        std::size_t longest = 0;
        bool is_like_an_echo = false;
        for (std::size_t i = 0; i < p.count; ++i) {
            const table_extent& e = p.requests[i];
            add(read, e.of, e.address, e.quantity);
            REQUIRE(e.offset == offset);
            offset += bytes_of(e);
            longest = std::max(longest, 5 + bytes_of(e));
            const bool is_bits = e.of == table::coils || e.of == table::discrete_inputs;
            if (!is_bits) REQUIRE(e.quantity <= most);
            // The byte count at the place of the address's high byte, and 8 bytes like the request.
            if (is_bits && bytes_of(e) == 3 && e.address / 256 == 3) is_like_an_echo = true;
            if (i == 0) continue;
            const table_extent& before = p.requests[i - 1];
            REQUIRE(std::pair{before.of, before.address} < std::pair{e.of, e.address});
            if (before.of != e.of || before.address + before.quantity != e.address) continue;
            // Adjacent requests: the first row of the second one had no room.
            const auto next = std::find_if(
                rows, rows + N, [&](const table_row& r) { return r.of == e.of && r.address == e.address; });
            REQUIRE(next != rows + N);
            REQUIRE(!is_bits);
            REQUIRE(before.quantity + next->quantity > most);
            ++split;
        }
        REQUIRE(read == wanted);
        REQUIRE(p.bytes == offset);
        REQUIRE(p.longest_response == longest);
        REQUIRE(p.has_echo_like_response == is_like_an_echo);
        for (const table_row& r : rows) {
            const table_extent& e = p.request_of(r.of, r.address);
            REQUIRE(e.of == r.of);
            REQUIRE(e.address <= r.address);
            REQUIRE(r.address + r.quantity <= e.address + e.quantity);
        }
    }
    CHECK(sound > rounds / 50);
    CHECK((split > 0) == (N > 2));
}
} // namespace

TEST_CASE("a plan reads the rows of each table in the fewest requests, and no other address") {
    check_plans<1>(50);
    check_plans<2>(300);
    check_plans<5>(1000);
    check_plans<9>(3000);
}

TEST_CASE("a plan notes a response to a read of 17 to 24 bits that its echo could be") {
    for (const unsigned address : {0x02F0u, 0x0300u, 0x0310u, 0x0400u}) {
        for (unsigned quantity = 15; quantity < 27; ++quantity) {
            table_row one[]{{table::discrete_inputs, static_cast<u16>(address), static_cast<u16>(quantity)}};
            const auto p = detail::plan_tables<1>(std::move(one), 8);
            const bool is_like_an_echo = address / 256 == 3 && quantity > 16 && quantity <= 24;
            CHECK(p.has_echo_like_response == is_like_an_echo);
            const std::uint8_t echo[]{1,
                                      2,
                                      static_cast<std::uint8_t>(address >> 8),
                                      static_cast<std::uint8_t>(address),
                                      0,
                                      static_cast<std::uint8_t>(quantity)};
            CHECK(p.requests[0].is_repeated_by(echo) == is_like_an_echo);
            std::uint8_t other[6];
            for (std::size_t at = 2; at < 6; ++at) {
                std::copy(echo, echo + 6, other);
                other[at] = static_cast<std::uint8_t>(other[at] ^ 1u);
                CHECK(!p.requests[0].is_repeated_by(other));
            }
        }
    }
}

} // namespace table_plans_tests
