// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which requests an exchange of a blocking line takes, and how long their responses are: per kind of exchange, since a
// program pays only for the kinds that it has.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/line/blocking_line.hpp>
#include <servobus/modbus/response_lengths.hpp>

#include <tests/support/scripted_port.hpp>

namespace blocking_line_requests_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);
using line_type = blocking_line<tests::scripted_port, timing>;
using open_line =
    blocking_line<tests::scripted_port, timing, milliseconds(100), modbus::default_crc, modbus::open_lengths>;

// The length of the response; 0 for a request that is not taken.
template <bool IsBroadcast, bool IsAny> std::size_t length_after(const byte_list& body, std::size_t room) {
    std::array<std::uint8_t, 256> memory{};
    const byte_list request = framed(body);
    const line_type::exchange_for<response_limits, IsBroadcast, IsAny> x{
        request, byte_buffer{memory}.first(room), timing, response_limits{}};
    return x.response_size();
}
std::size_t usual(const byte_list& body, std::size_t room = 64) {
    return length_after<false, false>(body, room);
}
std::size_t any(const byte_list& body, std::size_t room = 64) {
    return length_after<false, true>(body, room);
}
std::size_t broadcast(const byte_list& body) { return length_after<true, true>(body, 64); }
} // namespace

TEST_CASE("a usual exchange takes functions 01..06, 0F and 10h") {
    CHECK(usual({1, 1, 0, 0, 0, 9}) == 7);
    CHECK(usual({1, 2, 0, 0, 0, 9}) == 7);
    CHECK(usual({1, 3, 0, 0, 0, 2}) == 9);
    CHECK(usual({1, 4, 0, 0, 0, 2}) == 9);
    CHECK(usual({1, 5, 0, 0, 0xFF, 0}) == 8);
    CHECK(usual({1, 6, 0, 0, 0, 2}) == 8);
    CHECK(usual({1, 0x0F, 0, 0, 0, 2, 1, 3}) == 8);
    CHECK(usual({1, 0x10, 0, 0, 0, 1, 2, 0, 3}) == 8);
    for (const byte_list& other :
         {byte_list{1, 7}, byte_list{1, 8, 0, 0, 0, 1}, byte_list{1, 0x11},
          byte_list{1, 0x16, 0, 0, 0, 1, 0, 2}, byte_list{1, 0x17, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 1},
          byte_list{1, 0x41, 1}})
        CHECK(usual(other) == 0);
}

TEST_CASE("an exchange of any function is as long as its request says, or as its room") {
    CHECK(any({1, 0x16, 0, 0, 0, 1, 0, 2}) == 10);
    CHECK(any({1, 0x17, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 1}) == 7);
    CHECK(any({1, 8, 0, 0, 0, 1}) == 8);
    CHECK(any({1, 0x11}) == 64);
    CHECK(any({1, 0x11}, 5) == 5);
    CHECK(any({1, 0x11}, 4) == 0);
    CHECK(any({1, 0x11}, 256) == 0); // longer than a frame of this line
    CHECK(any({1, 0, 1}) == 0);
    CHECK(any({1, 0x80, 1}) == 0);
    CHECK(any({1, 3, 0, 0, 0, 30}) == 0); // no room
}

TEST_CASE("a request goes to a node, to the peer at 255, or to all") {
    const auto reads = [](std::uint8_t address) { return byte_list{address, 3, 0, 0, 0, 1}; };
    CHECK(usual(reads(1)) == 7);
    CHECK(usual(reads(247)) == 7);
    CHECK(usual(reads(255)) == 7);
    CHECK(usual(reads(248)) == 0);
    CHECK(usual(reads(254)) == 0);
    CHECK(usual(reads(0)) == 0);
    CHECK(broadcast({0, 6, 0, 0, 0, 1}) == 8);
    CHECK(broadcast({1, 6, 0, 0, 0, 1}) == 0);
    CHECK(broadcast({255, 6, 0, 0, 0, 1}) == 0);
    CHECK(broadcast(reads(0)) == 0);
    CHECK(broadcast({0, 0x41, 1}) == 0);
}

TEST_CASE("a rule counts only where the request does not say the length") {
    using modbus::length_rule;
    std::array<std::uint8_t, 64> room{};
    const auto room_for = [&](const byte_list& body, length_rule rule) {
        const byte_list request = framed(body);
        const open_line::exchange_for<response_limits, false, true> x{
            request, room, rule, timing, response_limits{}, priority{}};
        return x.response_size();
    };
    CHECK(room_for({1, 3, 0, 0, 0, 2}, length_rule::fixed(20)) == 9);
    CHECK(room_for({1, 0x41, 1}, length_rule::fixed(20)) == 64);
    CHECK(room_for({1, 0x41, 1}, length_rule::fixed(1)) == 64);
    CHECK(room_for({1, 0x41, 1}, length_rule::fixed(0)) == 0);
    CHECK(room_for({250, 0x41, 1}, length_rule::fixed(20)) == 0);
}

} // namespace blocking_line_requests_tests
