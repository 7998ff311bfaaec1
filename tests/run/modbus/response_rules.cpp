// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a request says of its response, and the rules for those it says nothing of: against figures from the standard
// (Modbus Application Protocol V1.1b3, section 6).
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <servobus/modbus/response_lengths.hpp>
#include <servobus/modbus/response_rules.hpp>

#include <tests/support/byte_times.hpp>

namespace response_rules_tests {

using namespace servobus;
using byte_times::byte_list;
using byte_times::framed;
using modbus::length_rule;

namespace {
unsigned length_after(const byte_list& body) { return modbus::expected_response(framed(body)); }
byte_list with_quantity(unsigned code, unsigned quantity) {
    return {3, static_cast<std::uint8_t>(code),          0,
            7, static_cast<std::uint8_t>(quantity >> 8), static_cast<std::uint8_t>(quantity)};
}
constexpr unsigned unknown = 0xFFFF;
} // namespace

TEST_CASE("the length of the response to a read follows from the quantity, 0 for one that is not allowed") {
    for (unsigned quantity = 0; quantity < 2100; ++quantity) {
        CAPTURE(quantity);
        const unsigned bits = quantity == 0 || quantity > 2000 ? 0 : 5 + (quantity + 7) / 8;
        const unsigned words = quantity == 0 || quantity > 125 ? 0 : 5 + 2 * quantity;
        CHECK(length_after(with_quantity(1, quantity)) == bits);
        CHECK(length_after(with_quantity(2, quantity)) == bits);
        CHECK(length_after(with_quantity(3, quantity)) == words);
        CHECK(length_after(with_quantity(4, quantity)) == words);
        byte_list both = with_quantity(0x17, quantity);
        both.insert(both.end(), {0, 1, 0, 1, 2, 0, 9});
        CHECK(length_after(both) == words);
    }
}

TEST_CASE("the length of a response that repeats its request, 0 for a request of another length") {
    CHECK(length_after({3, 1, 0, 7, 0, 1, 0}) == 0);
    CHECK(length_after({3, 1, 0, 7, 0}) == 0);
    CHECK(length_after({3, 0x17, 0, 7, 0, 1, 0, 1, 0, 1}) == 0);
    CHECK(length_after({3, 5, 0, 7, 0xFF, 0}) == 8);
    CHECK(length_after({3, 5, 0, 7, 0xFF}) == 0);
    CHECK(length_after({3, 5, 0, 7, 0xFF, 0, 0}) == 0);
    CHECK(length_after({3, 6, 0, 7, 0, 1}) == 8);
    CHECK(length_after({3, 6, 0, 7, 0, 1, 0}) == 0);
    CHECK(length_after({3, 0x0F, 0, 7, 0, 1, 1, 1}) == 8);
    CHECK(length_after({3, 0x0F, 0, 7, 0, 1, 1}) == 0);
    CHECK(length_after({3, 0x10, 0, 7, 0, 1, 2, 0, 1}) == 8);
    CHECK(length_after({3, 0x10, 0, 7, 0}) == 0);
    CHECK(length_after({3, 0x16, 0, 7, 0, 1, 0, 2}) == 10);
    CHECK(length_after({3, 0x16, 0, 7, 0, 1}) == 0);
    CHECK(length_after({3, 8, 0, 0, 1, 2}) == 8); // Return Query Data
    CHECK(length_after({3, 8, 0, 0, 1, 2, 3, 4}) == 10);
    CHECK(length_after({3, 8, 0, 0}) == unknown); // without data it is none
    CHECK(length_after({3, 8, 0, 2, 0, 0}) == unknown);
    for (const unsigned code : {7u, 0x0Bu, 0x0Cu, 0x11u, 0x18u, 0x2Bu, 0x41u})
        CHECK(length_after({3, static_cast<std::uint8_t>(code), 1, 2}) == unknown);
}

TEST_CASE("requests that change nothing in a device") {
    for (unsigned code = 1; code < 128; ++code) {
        CAPTURE(code);
        const std::uint8_t pdu[]{static_cast<std::uint8_t>(code), 0x0E};
        const bool only_reads = code <= 4 || code == 7 || code == 0x0B || code == 0x0C || code == 0x11 ||
                                code == 0x18 || code == 0x2B;
        CHECK(modbus::only_reads(pdu) == only_reads);
    }
    CHECK(!modbus::only_reads(byte_list{0x2B}));
    CHECK(!modbus::only_reads(byte_list{0x2B, 0x0D})); // CANopen
}

TEST_CASE("a rule is valid if the response has its parts in 1 to 253 bytes") {
    for (unsigned n = 0; n < 256; ++n) {
        CAPTURE(n);
        const auto byte = static_cast<std::uint8_t>(n);
        CHECK(length_rule::fixed(byte).is_valid() == (n >= 1 && n <= 253));
        CHECK(length_rule::counted(byte).is_valid() == (n >= 1 && n <= 252));
    }
    CHECK(length_rule::of_function().is_valid());
    CHECK(length_rule::until_gap().is_valid());
    CHECK(length_rule::until_gap().ends_by_gap());
    CHECK(!length_rule::fixed(9).ends_by_gap());
}

TEST_CASE("a rule says how many bytes a response has at least") {
    const byte_list request{0x41, 7};
    const byte_list begun{0x41, 3, 1, 0};
    const auto least = [&](length_rule rule, std::size_t count) {
        return modbus::open_lengths{rule, request}.least_length(bytes{begun}.first(count));
    };
    for (std::size_t count = 1; count <= begun.size(); ++count) {
        CHECK(least(length_rule::fixed(9), count) == 9);
        CHECK(least(length_rule::counted(1), count) == (count < 2 ? 2 : 5));
        CHECK(least(length_rule::counted(3), count) == 4);
        CHECK(least(length_rule::until_gap(), count) == 253); // only a gap ends it before
    }
}

} // namespace response_rules_tests
