// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A response that arrives in one piece ends like one that arrives byte by byte, also where it is as long as its
// request, and where a rule says its length.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/response_lengths.hpp>

#include <tests/support/exchange_runs.hpp>

namespace whole_responses_tests {

using namespace servobus;
using namespace tests::exchange_runs;
using modbus::length_rule;
using tests::byte_list;
using tests::framed;

namespace {
using open_exchange = modbus::basic_exchange<modbus::default_crc, modbus::open_lengths>;

struct end {
    errc why;
    bool differs; // from its request
    byte_list response;

    bool operator==(const end&) const = default;
};

template <class Exchange> end end_of(Exchange& x, const byte_list& response, std::size_t piece) {
    x.sent({0});
    std::uint32_t now = 2000;
    for (std::size_t at = 0; at < response.size() && !x.done(); at += piece) {
        const std::size_t size = response.size() - at < piece ? response.size() - at : piece;
        now += host.wire_time(size).us;
        x.feed(bytes{response}.subspan(at, size), {now});
    }
    x.elapse({now + 300'000});
    REQUIRE(x.done());
    return {x.status().error(), x.differs_from_request(), {x.response().begin(), x.response().end()}};
}
// In one piece; the other sizes end alike.
end end_of(const byte_list& request, const byte_list& response) {
    end ends[3]{};
    std::size_t i = 0;
    for (const std::size_t piece : {response.size(), std::size_t{1}, std::size_t{3}}) {
        std::array<std::uint8_t, 256> room{};
        modbus::exchange x{request, byte_buffer{room}.first(response.size()), host, usual};
        if (request[1] == 0x17) x.judge_like(modbus::like(0x17));
        ends[i++] = end_of(x, response, piece);
    }
    CHECK(ends[0] == ends[1]);
    CHECK(ends[0] == ends[2]);
    return ends[0];
}
} // namespace

TEST_CASE("a response as long as its request differs from it, or is its echo, however it arrives") {
    const byte_list coils = framed({0x01, 0x01, 0x03, 0x13, 0x00, 0x18}); // 24 of them: 3 bytes
    const byte_list values = framed({0x01, 0x01, 0x03, 0xCD, 0x6B, 0x05});
    CHECK(end_of(coils, values) == end{errc::ok, true, values});
    CHECK(end_of(coils, coils) == end{errc::ok, false, coils});

    const byte_list both = framed({0x01, 0x17, 0x0A, 0x10, 0, 5, 0, 0, 0, 1, 2, 0, 7});
    const byte_list words = framed({0x01, 0x17, 0x0A, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5});
    CHECK(both.size() == words.size());
    CHECK(end_of(both, words) == end{errc::ok, true, words});
    CHECK(end_of(both, both) == end{errc::ok, false, both});
}

TEST_CASE("a response whose length a rule says ends alike, however it arrives") {
    struct row {
        byte_list request; // without their CRC
        length_rule rule;
        byte_list response;
        errc why;
    };
    const row rows[] = {
        {{1, 0x41, 7}, length_rule::fixed(4), {1, 0x41, 9, 8, 3}, errc::ok},
        {{1, 0x41, 7}, length_rule::counted(1), {1, 0x41, 2, 8, 3}, errc::ok},
        {{1, 0x41, 7}, length_rule::until_gap(), {1, 0x41, 9, 8, 3}, errc::ok},
        {{1, 0x41, 7}, length_rule::until_gap(), {1, 0xC1, 2}, errc::exception},
        {{1, 0x11}, length_rule::of_function(), {1, 0x11, 3, 7, 0xFF, 1}, errc::ok},
        {{1, 0x41, 7}, length_rule::fixed(4), {1, 0x42, 9, 8, 3}, errc::wrong_function},
        {{1, 3, 0, 0, 0, 1}, length_rule::fixed(9), {1, 3, 2, 0, 5}, errc::ok}, // the request says it
    };
    for (const row& r : rows) {
        const byte_list request = framed(r.request);
        const byte_list response = framed(r.response);
        for (const std::size_t piece : {response.size(), std::size_t{1}, std::size_t{3}}) {
            CAPTURE(response);
            CAPTURE(piece);
            std::array<std::uint8_t, 64> room{};
            open_exchange x{request, room, r.rule, host, usual, {}};
            if (r.request[1] == 3)
                x = open_exchange{request, byte_buffer{room}.first(7), r.rule, host, usual, {}};
            const end e = end_of(x, response, piece);
            CHECK(e.why == r.why);
            CHECK(e.differs);
            if (e.why == errc::ok) CHECK(e.response == response);
        }
    }
}

TEST_CASE("a response of a rule may take as long as one that fills its room") {
    const byte_list request = framed({1, 0x41, 7});
    for (const std::size_t size : {std::size_t{8}, std::size_t{100}, std::size_t{256}}) {
        std::array<std::uint8_t, 256> room{};
        const byte_buffer there = byte_buffer{room}.first(size);
        const open_exchange counted{request, there, length_rule::counted(1), host, usual, {}};
        const open_exchange until_gap{request, there, length_rule::until_gap(), host, usual, {}};
        const modbus::exchange fixed{request, there, host, usual}; // as long as the room
        CHECK(counted.longest() == fixed.longest());
        CHECK(until_gap.longest() == fixed.longest());
        CHECK(counted.longest_before_stop() == fixed.longest_before_stop());
    }
    std::array<std::uint8_t, 64> room{};
    const byte_list read = framed({1, 3, 0, 0, 0, 1});
    const open_exchange known{read, byte_buffer{room}.first(7), length_rule::until_gap(), host, usual, {}};
    CHECK(known.longest() == modbus::exchange{read, byte_buffer{room}.first(7), host, usual}.longest());
}

TEST_CASE("a rule that is none, a broadcast and a request that is none have no exchange of open length") {
    std::array<std::uint8_t, 64> room{};
    const auto why = [&](const byte_list& request, length_rule rule) {
        const open_exchange x{request, room, rule, host, usual, {}};
        return x.done() ? x.status().error() : errc::ok;
    };
    CHECK(why(framed({1, 0x41, 7}), length_rule::counted(1)) == errc::ok);
    CHECK(why(framed({1, 0x41, 7}), length_rule::counted(0)) == errc::bad_argument);
    CHECK(why(framed({0, 0x41, 7}), length_rule::counted(1)) == errc::bad_argument);
    CHECK(why(framed({1, 0x81, 7}), length_rule::counted(1)) == errc::bad_argument);
    CHECK(why(framed({250, 0x41, 7}), length_rule::counted(1)) == errc::bad_argument);
}

} // namespace whole_responses_tests
