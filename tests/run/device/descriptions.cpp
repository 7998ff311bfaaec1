// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The sentence about each register: every register of the four maps has exactly one, in short ASCII text. The manuals'
// tables in tests/manuals/ say which registers there are.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include <tests/support/manual.hpp>

namespace descriptions_tests {

using namespace servobus;

struct tested {
    const char* name;
    const servobus::catalogue* map;
    std::size_t registers;
};
constexpr tested devices[] = {
    {"zlac8015d", &zlac8015d::catalogue, 116},
    {"yako_closed_loop", &yako::closed_loop::catalogue, 204},
    {"yako_open_loop", &yako::open_loop::catalogue, 208},
    {"c630s", &c630s::catalogue, 463},
};

// A register of a map, and one that has a sentence, are the same registers.
constexpr description two[] = {{0x0003, "Opens the valve."}, {0x0010, "Shows the level."}};
constexpr std::array<entry, 2> entries_of(u16 first, u16 second) {
    return {entry{first, "first", value_kind::unsigned_word, access::ro, {}, 0, {}, {}},
            entry{second, "second", value_kind::signed_pair, access::ro, {}, 0, {}, {}}};
}
constexpr std::array<entry, 2> both = entries_of(0x0003, 0x0010);
static_assert(is_described(both, two));
static_assert(!is_described(entries_of(0x0003, 0x0011), two));
static_assert(!is_described(entries_of(0x0004, 0x0010), two));
static_assert(!is_described(std::span{both}.first(1), two));
static_assert(!is_described(both, std::span{two}.first(1)));

TEST_CASE("a register's sentence is found by its address, of a pair by both") {
    static constexpr profile facts{.name = "tank"};
    const servobus::catalogue map{&facts, both, two};
    CHECK(map.sentence(0x0003) == two[0].sentence);
    CHECK(map.sentence(0x0010) == two[1].sentence);
    CHECK(map.sentence(0x0011) == two[1].sentence);
    for (const u16 without : std::array<u16, 6>{0x0000, 0x0002, 0x0004, 0x000F, 0x0012, 0xFFFF}) {
        CAPTURE(without);
        CHECK(std::string{map.sentence(without)}.empty());
    }
    const servobus::catalogue silent{&facts, both};
    CHECK(std::string{silent.sentence(0x0003)}.empty());
}

TEST_CASE("two tables are joined in address order") {
    constexpr description others[] = {{0x0000, "a"}, {0x0005, "b"}, {0xFFFF, "c"}};
    constexpr auto all = joined(two, others);
    static_assert(all.size() == 5 && joined(others, two).size() == 5);
    std::string order;
    for (const description& d : all) order += d.sentence[0];
    CHECK(order == "aObSc");
    CHECK(joined(others, two)[1].sentence == two[0].sentence);
}

TEST_CASE("each register has exactly one sentence, and no sentence is without a register") {
    for (const tested& of : devices) {
        CAPTURE(std::string{of.name});
        CHECK(of.map->entries.size() == of.registers);
        std::set<u16> described;
        for (const description& d : of.map->descriptions) {
            CAPTURE(d.address);
            CHECK(described.insert(d.address).second);
        }
        CHECK(described.size() == of.registers);
        for (const entry& e : of.map->entries) {
            CAPTURE(static_cast<const char*>(e.name));
            CHECK(described.count(e.address) == 1);
            CHECK_FALSE(std::string{of.map->sentence(e.address)}.empty());
        }
    }
}

TEST_CASE("a sentence is short ASCII text") {
    for (const tested& of : devices) {
        CAPTURE(std::string{of.name});
        for (const description& d : of.map->descriptions) {
            CAPTURE(d.address);
            REQUIRE(d.sentence != nullptr);
            const std::string all = d.sentence;
            CAPTURE(all);
            REQUIRE(all.size() > 1);
            std::size_t words = 1;
            for (const char c : all) {
                CHECK(c >= ' ');
                CHECK(c <= '~');
                CHECK(c != '"'); // the tool prints it between quotes
                if (c == ' ') ++words;
            }
            CHECK(words <= 20);
            CHECK(all.front() >= 'A');
            CHECK(all.front() <= 'Z');
            CHECK(all.back() == '.');
            CHECK(all.find("  ") == std::string::npos);
        }
    }
}

TEST_CASE("every address of a manual's table has a sentence") {
    for (const tested& of : devices) {
        const std::vector<std::string> lines = tests::manual(std::string{of.name} + ".tsv");
        REQUIRE(lines.size() > of.registers); // and a line with the names of the columns
        for (std::size_t i = 1; i < lines.size(); ++i) {
            CAPTURE(lines[i]);
            const auto address = tests::number(tests::split(lines[i], '\t')[0]);
            REQUIRE(address.has_value());
            CHECK_FALSE(std::string{of.map->sentence(static_cast<u16>(*address))}.empty());
        }
    }
}

} // namespace descriptions_tests
