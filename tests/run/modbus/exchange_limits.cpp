// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response at the limits of sizes, times and counts: responses of every length in one
// piece, in a buffer of their own or a shared one; a pause after a response that may be an echo; more frames
// of other nodes than a counter holds.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/modbus/exchange.hpp>

#include <tests/support/scripted_port.hpp>

namespace exchange_limits_tests {

using namespace servobus;
using modbus::exchange;
using tests::byte_list;
using tests::framed;
using tests::operator+;

namespace {

constexpr modbus::rtu_timing host = modbus::timing_at(115200);
constexpr modbus::rtu_timing strict = modbus::timing_at(9600, modbus::timing_mode::strict);
constexpr response_limits usual{};

byte_list read_of(unsigned words) { return framed({1, 3, 0x20, 0xA0, 0, tests::low_byte(words)}); }

// No two bytes that are 8 or 16 apart are equal, so that a block in the wrong place is noticed.
byte_list response_of(unsigned words) {
    std::vector<std::uint16_t> values;
    for (unsigned i = 0; i < words; ++i) values.push_back(static_cast<std::uint16_t>(0x0102 + 0x0205 * i));
    return tests::read_response(1, values);
}

// The request for one register whose first seven bytes are a well-formed response to it.
const byte_list like_an_answer{0x06, 0x03, 0x02, 0x12, 0x00, 0x01, 0x24, 0x00};

} // namespace

TEST_CASE("a response of any length that arrives in one piece is copied to its last byte and no further") {
    for (unsigned words = 1; words <= 125; ++words) {
        CAPTURE(words);
        const byte_list request = read_of(words);
        const byte_list response = response_of(words);
        byte_list memory(response.size() + 64, 0xA5);
        exchange x{request, byte_buffer{memory}.subspan(32, response.size()), host, usual};
        x.sent({0});
        REQUIRE(x.feed(response + byte_list(3, 0x77), {1000}) == response.size());
        REQUIRE(x.status() == errc::ok);
        REQUIRE(same_bytes(x.response(), response));
        REQUIRE(memory == byte_list(32, 0xA5) + response + byte_list(32, 0xA5));
    }
}

TEST_CASE("a function of the device's own has a response of any length, also in one piece") {
    for (std::size_t size = 5; size <= 256; ++size) {
        CAPTURE(size);
        byte_list body{1, 0x41};
        while (body.size() < size - 2) body.push_back(static_cast<std::uint8_t>(7 * body.size()));
        const byte_list response = framed(body);
        const byte_list request = framed({1, 0x41, 9});
        byte_list memory(size + 64, 0xA5);
        exchange x{request, byte_buffer{memory}.subspan(32, size), host, usual};
        x.sent({0});
        REQUIRE(x.feed(response, {1000}) == size);
        REQUIRE(x.status() == errc::ok);
        REQUIRE(memory == byte_list(32, 0xA5) + response + byte_list(32, 0xA5));
    }
}

TEST_CASE("received bytes may lie in the response's own memory, at its beginning or after it") {
    for (unsigned words = 1; words <= 125; ++words) {
        for (const std::size_t behind : {0u, 1u, 5u, 8u, 13u, 16u, 17u, 40u}) {
            CAPTURE(words);
            CAPTURE(behind);
            const byte_list request = read_of(words);
            const byte_list response = response_of(words);
            byte_list memory = byte_list(behind, 0xA5) + response;
            exchange x{request, byte_buffer{memory}.first(response.size()), host, usual};
            x.sent({0});
            REQUIRE(x.feed(bytes{memory}.subspan(behind), {1000}) == response.size());
            REQUIRE(x.status() == errc::ok);
            REQUIRE(same_bytes(x.response(), response));
        }
    }
}

TEST_CASE("G3: a pause makes a maybe echo a response, also if only the next byte shows the pause") {
    const byte_list response(like_an_answer.begin(), like_an_answer.end() - 1);
    for (const modbus::rtu_timing& timing : {host, strict}) {
        for (const std::uint8_t next :
             std::array<std::uint8_t, 2>{0x00, 0x06}) { // 00 is how the request continues
            for (const std::uint32_t pause : {timing.longest_gap(1).us, timing.longest_gap(1).us + 1}) {
                CAPTURE(next);
                CAPTURE(pause);
                std::array<std::uint8_t, 7> room{};
                exchange x{like_an_answer, room, timing, usual};
                x.sent({0});
                for (const std::uint8_t b : response) x.feed(b, {1000});
                REQUIRE(x.state() == exchange::phase::receiving);
                CHECK(x.feed(next, {1000 + pause}) == 0);
                REQUIRE(x.done());
                const bool is_echo = next == 0x00 && pause == timing.longest_gap(1).us;
                CHECK(x.status().error() == (is_echo ? errc::own_echo : errc::ok));
                CHECK(x.words().size() == (is_echo ? 0 : 1));
            }
        }
    }
}

TEST_CASE("G11: after any number of frames of other nodes the response is still accepted") {
    const byte_list foreign = tests::read_response(2, {0x1234});
    for (const unsigned passing : {1u, 254u, 255u, 256u, 300u, 600u}) {
        CAPTURE(passing);
        std::array<std::uint8_t, 7> room{};
        const byte_list request = read_of(1);
        exchange x{request, room, host, usual};
        x.sent({0});
        for (unsigned i = 0; i < passing; ++i) CHECK(x.feed(foreign, {1000}) == foreign.size());
        CHECK(x.feed(response_of(1), {2000}) == 7);
        CHECK(x.status() == errc::ok);
        CHECK(x.words()[0] == 0x0102);
    }
}

TEST_CASE("any byte after a request shows that something was received, a skipped one too") {
    const byte_list nothing{};
    const byte_list skipped{0xFF};
    const byte_list of_another{9};
    for (const byte_list& came : {nothing, skipped, of_another, byte_list{1}}) {
        std::array<std::uint8_t, 16> room{};
        response_limits lenient;
        lenient.leading_bytes = 1;
        const byte_list request = read_of(1);
        exchange x{request, room, host, lenient};
        x.begin_leaving();
        x.sent({1000});
        CHECK_FALSE(x.has_received());
        x.feed(came, {2000});
        CHECK(x.has_received() == !came.empty());
        x.elapse({1'000'000});
        CHECK(x.status().error() == (came == byte_list{1} ? errc::truncated_response : errc::timeout));
        CHECK(x.has_received() == !came.empty());
    }
}

TEST_CASE("G5: up to 255 leading bytes may be skipped, and not one more") {
    response_limits lenient;
    lenient.leading_bytes = 255;
    for (const std::size_t leading : {254u, 255u, 256u, 257u, 600u}) {
        CAPTURE(leading);
        std::array<std::uint8_t, 7> room{};
        const byte_list request = read_of(1);
        exchange x{request, room, host, lenient};
        x.sent({0});
        x.feed(byte_list(leading, 0xFF) + response_of(1), {2000});
        x.elapse({200'000});
        CHECK(x.status().error() == (leading <= 255 ? errc::ok : errc::timeout));
    }
}

TEST_CASE("G3: a byte that is not the next one of the request ends a maybe echo immediately as a response") {
    const byte_list response(like_an_answer.begin(), like_an_answer.end() - 1);
    for (const std::uint8_t next : std::array<std::uint8_t, 3>{0x00, 0x01, 0xFF}) {
        CAPTURE(next);
        std::array<std::uint8_t, 7> room{};
        exchange x{like_an_answer, room, host, usual};
        x.sent({0});
        CHECK(x.feed(response + byte_list{next, 0x55}, {1000}) == 7);
        CHECK(x.status().error() == (next == 0x00 ? errc::own_echo : errc::ok));
    }
}

TEST_CASE("in memory that is shared with the request a response that ends in zero is accepted") {
    int found = 0;
    for (unsigned value = 0; value < 2000; ++value) {
        const byte_list response = tests::read_response(1, {static_cast<std::uint16_t>(value), 0});
        if (response.back() != 0) continue;
        ++found;
        for (const std::size_t piece : {std::size_t{1}, response.size()}) {
            byte_list shared = read_of(2);
            shared.resize(response.size());
            exchange x{bytes{shared}.first(8), shared, host, usual};
            x.sent({0});
            for (std::size_t at = 0; at < response.size(); at += piece)
                x.feed(bytes{response}.subspan(at, piece), {1000});
            CHECK(x.status() == errc::ok);
        }
    }
    CHECK(found > 0);
}

TEST_CASE("an exchange takes no bytes before it was sent or after its end, and has no words until then") {
    const byte_list request = read_of(1);
    const byte_list response = response_of(1);
    std::array<std::uint8_t, 7> room{};
    exchange x{request, room, host, usual};
    CHECK(x.elapse({5'000'000}) == duration{});
    for (const std::uint8_t b : response) CHECK(x.feed(b, {0}) == 0);
    CHECK(x.feed(response, {0}) == 0);
    CHECK(x.state() == exchange::phase::ready);
    CHECK_FALSE(x.has_received());
    x.sent({0});
    CHECK(x.feed(bytes{response}.first(6), {1000}) == 6);
    CHECK(x.words().size() == 0);
    CHECK(x.feed(bytes{response}.subspan(6), {1000}) == 1);
    CHECK(x.words().size() == 1);
    CHECK(x.feed(response, {1000}) == 0);
    CHECK(x.elapse({5'000'000}) == duration{});
    CHECK(x.status() == errc::ok);
}

TEST_CASE("G10: the response to a function of the device's own is no longer than a frame, however large its "
          "buffer is") {
    const byte_list request = framed({1, 0x41, 9});
    byte_list room(400);
    for (const std::size_t size : {255u, 256u, 257u, 400u}) {
        const exchange x{request, byte_buffer{room}.first(size), host, usual};
        CHECK(x.response_size() == (size < 256 ? size : 256));
    }
}

TEST_CASE("G11: after another node's frame and a gap the response is accepted, also if elapse() was not "
          "called in the gap") {
    const byte_list request = read_of(1);
    for (const byte_list& other : {framed({2, 3, 4, 1, 2, 3, 4}), byte_list{0x41, 0x42, 0x43}}) {
        std::array<std::uint8_t, 7> room{};
        exchange x{request, room, host, usual};
        x.sent({0});
        x.feed(other, {1000});
        CHECK(x.state() != exchange::phase::done);
        x.feed(response_of(1), {1000 + host.longest_gap(7).us + 1});
        CHECK(x.done());
        CHECK(x.status() == errc::ok);
    }
}

TEST_CASE("G3: a clock that goes back has measured no gap after a whole response that may be an echo") {
    for (const bool byte_follows : {false, true}) {
        for (const std::uint32_t at :
             {0u, 1'000'000u, 1'001'575u, 1'001'576u}) { // the last byte came at ..576
            CAPTURE(byte_follows);
            CAPTURE(at);
            std::array<std::uint8_t, 8> room{};
            exchange x{like_an_answer, room, host, usual};
            x.sent(instant{1'000'000});
            for (std::uint32_t i = 0; i < 7; ++i) x.feed(like_an_answer[i], instant{1'001'000 + 96 * i});
            REQUIRE(x.state() == exchange::phase::receiving);
            const instant now{at};
            if (byte_follows)
                x.feed(like_an_answer[7], now);
            else
                x.elapse(now);
            const bool is_known = byte_follows || at < 1'001'576;
            CHECK(x.done() == is_known);
            if (is_known) CHECK(x.status().error() == errc::own_echo);
        }
    }
}

} // namespace exchange_limits_tests
