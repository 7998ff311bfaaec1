// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How `servobus doctor` reads the registers of its checks, and what it does with those that it does not get.
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/catalogue.hpp>

#include <examples/servobus/doctor/check.hpp>
#include <examples/servobus/doctor/reading.hpp>

namespace doctor_reading_tests {
namespace {

namespace zlac = servobus::zlac8015d;
using namespace tool::diagnosis;
using servobus::entry;
using servobus::status;

/// Registers that hold their own address; some are refused, and from one on there is no response.
struct peer {
    u16 refused = 0;
    u16 silent = 0xFFFF;
    std::vector<std::string> requests{};

    status operator()(std::span<const entry* const> rows, std::span<u16> words) {
        const u16 first = rows[0]->address;
        requests.push_back(hex_of(first) + '+' + std::to_string(words.size()));
        for (std::size_t i = 0; i < words.size(); ++i) {
            words[i] = static_cast<u16>(first + i);
            if (words[i] == refused) return status::sent(servobus::errc::exception, 2);
            if (words[i] >= silent) return status::sent(servobus::errc::timeout);
        }
        return {};
    }
};

constexpr check checks[] = {
    {refuses, {zlac::left_faults}, is_set, "one"},
    {matters, {zlac::left_actual_position}, is_set, "two"},
    {matters, {zlac::status_word, zlac::host_timeout}, is_set, "three"},
};
constexpr check_list list{checks};

std::vector<std::string> whys(const held_registers& held) {
    std::vector<std::string> all;
    for (const check* c : find(list, held)) all.emplace_back(c->why);
    return all;
}

TEST_CASE("doctor reads adjacent registers together, each once, in address order") {
    held_registers held;
    peer p;
    const auto rows = rows_of(list, zlac::catalogue);
    CHECK(rows.size() == 4);
    CHECK(read_into(held, rows, 125, std::ref(p)).empty());
    CHECK(p.requests == std::vector<std::string>{"0x2000+1", "0x20A2+1", "0x20A5+1", "0x20A7+2"});
    CHECK(held.word(zlac::host_timeout) == 0x2000);
    CHECK(held.pair(0x20A7) == 0x20A720A8u);
    CHECK(whys(held) == std::vector<std::string>{"one", "two", "three"});
    const entry* const block[] = {zlac::catalogue.find(0x20A5), zlac::catalogue.find(0x20A6),
                                  zlac::catalogue.find(0x20A7), zlac::catalogue.find(0x20A9)};
    p.requests.clear();
    CHECK(read_into(held, block, 125, std::ref(p)).empty());
    CHECK(read_into(held, block, 3, std::ref(p)).empty());
    CHECK(p.requests == std::vector<std::string>{"0x20A5+6", "0x20A5+2", "0x20A7+2", "0x20A9+2"});
}

TEST_CASE("a register that is refused is left out with its checks") {
    held_registers held;
    peer p{.refused = 0x20A6};
    const entry* const block[] = {zlac::catalogue.find(0x20A5), zlac::catalogue.find(0x20A6),
                                  zlac::catalogue.find(0x20A7)};
    const auto missing = read_into(held, block, 125, std::ref(p));
    REQUIRE(missing.size() == 1);
    CHECK(missing[0].row->address == 0x20A6);
    CHECK(missing[0].why.exception() == 2);
    CHECK(held.has(0x20A5));
    CHECK(!held.has(0x20A6));
    CHECK(held.has(0x20A8));
    CHECK(whys(held) == std::vector<std::string>{"one", "two"});
    p.refused = 0x20A2;
    const auto alone = read_into(held, rows_of(list, zlac::catalogue), 125, std::ref(p));
    CHECK(alone.size() == 1);
    CHECK(whys(held) == std::vector<std::string>{"one", "two"});
}

TEST_CASE("where the response stays out nothing more is asked") {
    held_registers held;
    peer p{.silent = 0x20A5};
    const auto missing = read_into(held, rows_of(list, zlac::catalogue), 125, std::ref(p));
    REQUIRE(missing.size() == 1);
    CHECK(missing[0].why.error() == servobus::errc::timeout);
    CHECK(p.requests.size() == 3);
    CHECK(!has_refusal(find(list, held)));
}

} // namespace
} // namespace doctor_reading_tests
