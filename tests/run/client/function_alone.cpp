// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A response that is the function alone, as PZEM meters answer the reset of their energy: 42h by 01 42 80 11. Every
// form of the library receives it, and takes no echo, exception or other function for it.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/client/open_responses.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>

namespace function_alone_tests {

using namespace servobus;
using namespace tests::typed;
using modbus::length_rule;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(9600);
const byte_list reset = {0x01, 0x42, 0x80, 0x11}; // as the meter's manual prints it, request and response

struct any_line {
    using type = servobus::line<tests::waiting_scripted_port>;
    static type on(tests::waiting_scripted_port& port) { return type{port, timing}; }
};
struct small_line {
    using type = blocking_line<tests::waiting_scripted_port, timing>;
    static type on(tests::waiting_scripted_port& port) { return type{port}; }
};
struct any_open_line {
    using type = servobus::line<tests::waiting_scripted_port, counters, unechoed, modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port, timing}; }
};
struct small_open_line {
    using type = blocking_line<tests::waiting_scripted_port, timing, milliseconds(100), modbus::default_crc,
                               modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port}; }
};
struct strict_open_line {
    static constexpr modbus::rtu_timing strict = modbus::timing_at(9600, modbus::timing_mode::strict);
    using type = servobus::line<tests::waiting_scripted_port, counters, unechoed, modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port, strict}; }
};

/// A meter that sends `answers` to what is no read, and a value to a read.
template <class Kind> struct meter {
    tests::waiting_scripted_port port;
    typename Kind::type on{Kind::on(port)};
    client<typename Kind::type, device> io{on, node<device>{1}};
    byte_list answers = reset;

    explicit meter(bool rules_out_echo = true) {
        port.device = [this](scripted_port& p, const tests::sent_frame& f) {
            p.say(5000, f.data[1] == 3 ? framed({1, 3, 2, 0, 7}) : answers);
        };
        u16 word[1]{};
        if (rules_out_echo) REQUIRE(io.read_words(2, word));
    }
    meter(const meter&) = delete;
    byte_list last() const { return port.frames.back().data; }
};

byte_list with_crc_over(byte_list data) { return framed(data); }
} // namespace

TEST_CASE_TEMPLATE("a response that is the function alone is received in a buffer of one byte", Kind,
                   any_line, small_line, any_open_line, small_open_line, strict_open_line) {
    meter<Kind> m;
    std::uint8_t answer[2]{0, 0xA5};
    CHECK(m.io.transact(hex("42"), byte_buffer{answer, 1}).error() == errc::ok);
    CHECK(m.last() == reset);
    CHECK(answer[0] == 0x42);
    CHECK(answer[1] == 0xA5);
    // Not with another CRC, function or address, not in part, and not with data.
    answer[0] = 0;
    const auto why = [&](const byte_list& answers) {
        m.answers = answers;
        const status s = m.io.transact(hex("42"), byte_buffer{answer, 1});
        CHECK(answer[0] == 0);
        return s;
    };
    CHECK(why({0x01, 0x42, 0x80, 0x12}).error() == errc::bad_crc);
    CHECK(why({0x01, 0x42, 0x80}).error() >= errc::truncated_response);
    CHECK(why(with_crc_over({0x01, 0x43})).error() == errc::wrong_function);
    CHECK(why(with_crc_over({0x02, 0x42})).error() == errc::timeout);
    CHECK(why(with_crc_over({0x01, 0x42, 0x07})).error() == errc::bad_crc);
    // An exception has five bytes here too.
    const status refused = why(with_crc_over({0x01, 0xC2, 0x02}));
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 2);
    CHECK(why({0x01, 0xC2, 0x02, 0xC1, 0xA0}).error() == errc::bad_crc);
    // A function whose response is longer has no place for it.
    const std::size_t sent = m.port.frames.size();
    CHECK(m.io.transact(hex("03 00 00 00 01"), byte_buffer{answer, 1}).error() == errc::bad_argument);
    CHECK(m.io.transact(hex("05 00 00 FF 00"), byte_buffer{answer, 1}).error() == errc::bad_argument);
    CHECK(m.io.transact(hex("08 00 00 12 34"), byte_buffer{answer, 1}).error() == errc::bad_argument);
    CHECK(m.io.transact(hex("42"), byte_buffer{}).error() == errc::bad_argument);
    CHECK(m.port.frames.size() == sent);
}

TEST_CASE_TEMPLATE(
    "G3: a response that is the function alone and equals its request is the line's own echo until that is "
    "ruled out",
    Kind, any_line, small_line, any_open_line, small_open_line, strict_open_line) {
    meter<Kind> m{false};
    std::uint8_t answer[1]{};
    CHECK(m.io.transact(hex("42"), answer).error() == errc::own_echo);
    CHECK(answer[0] == 0);
    // A request with data differs from the response, which rules the echo out.
    CHECK(m.io.transact(hex("42 07"), answer).error() == errc::ok);
    CHECK(answer[0] == 0x42);
    CHECK(m.io.transact(hex("42"), answer).error() == errc::ok);
}

TEST_CASE_TEMPLATE("G3: the echo of a request that begins with the response is no response", Kind, any_line,
                   small_line, any_open_line, small_open_line, strict_open_line) {
    meter<Kind> m;
    std::uint8_t answer[1]{};
    const byte_list asked{0x42, 0x80, 0x11, 0x55}; // 01 42 80 11, and more
    m.answers = framed({0x01, 0x42, 0x80, 0x11, 0x55});
    CHECK(m.io.transact(asked, answer).error() == errc::own_echo);
    CHECK(m.last() == m.answers);
    m.answers = reset;
    CHECK(m.io.transact(asked, answer).error() == errc::ok);
}

TEST_CASE_TEMPLATE("a response that is the function alone is received by each rule that ends there", Kind,
                   any_open_line, small_open_line, strict_open_line) {
    for (const bool is_small : {false, true}) {
        std::array<std::uint8_t, 16> room{};
        const byte_buffer there = byte_buffer{room}.first(is_small ? 1 : 16);
        for (const length_rule rule : {length_rule::fixed(1), length_rule::until_gap()}) {
            meter<Kind> m; // of the one before an echo is possible again
            room.fill(0xA5);
            m.answers = reset;
            const result<bytes> alone = m.io.transact(hex("42"), there, rule);
            REQUIRE(alone.error() == errc::ok);
            CHECK(alone->size() == 1);
            CHECK((*alone)[0] == 0x42);
            CHECK(room[1] == 0xA5);
            room.fill(0xA5);
            m.answers = with_crc_over({0x01, 0xC2, 0x03});
            const result<bytes> refused = m.io.transact(hex("42"), there, rule);
            CHECK(refused.error() == errc::exception);
            CHECK(refused.status().exception() == 3);
            m.answers = {0x01, 0x42, 0x80, 0x12};
            CHECK(!m.io.transact(hex("42"), there, rule));
            m.answers = {0x01, 0xC2, 0x81, 0xB1}; // an exception without a number, its CRC is right
            REQUIRE(with_crc_over({0x01, 0xC2}) == m.answers);
            CHECK(!m.io.transact(hex("42"), there, rule));
            m.answers = with_crc_over({0x01, 0x42, 0x07});
            const result<bytes> longer = m.io.transact(hex("42"), there, rule);
            CHECK(static_cast<bool>(longer) == (!is_small && rule.ends_by_gap()));
            if (longer) CHECK(longer->size() == 2);
            if (is_small && rule.ends_by_gap()) CHECK(longer.error() == errc::too_long);
            for (std::size_t i = is_small ? 0 : 2; i < room.size(); ++i) CHECK(room[i] == 0xA5);
        }
    }
    meter<Kind> unproven{false};
    std::array<std::uint8_t, 16> room{};
    CHECK(unproven.io.transact(hex("42"), room, length_rule::fixed(1)).error() == errc::own_echo);
    CHECK(unproven.io.transact(hex("42"), room, length_rule::until_gap()).error() == errc::own_echo);
}

TEST_CASE("an exchange, alone and stepped on a line, receives a response that is the function alone") {
    constexpr response_limits limits{};
    std::array<std::uint8_t, 5> room{};
    const auto made = [&](const byte_list& request) {
        room.fill(0xA5);
        return modbus::exchange{request, room, timing, limits};
    };
    for (const std::size_t piece : {std::size_t{1}, std::size_t{2}, std::size_t{5}}) {
        CAPTURE(piece);
        for (const byte_list& answer : {reset, with_crc_over({0x01, 0xC2, 0x02})}) {
            modbus::exchange x = made(reset);
            x.expect_function_alone();
            CHECK(x.response_size() == 4);
            x.sent({0});
            std::uint32_t now = 5000;
            for (std::size_t at = 0; at < answer.size() && !x.done(); at += piece) {
                const std::size_t size = answer.size() - at < piece ? answer.size() - at : piece;
                now += timing.wire_time(size).us;
                (void)x.feed(bytes{answer}.subspan(at, size), {now});
            }
            REQUIRE(x.done());
            CHECK(x.status().error() == (answer.size() == 4 ? errc::ok : errc::exception));
            CHECK(byte_list{x.response().begin(), x.response().end()} == answer);
            CHECK(x.differs_from_request() == (answer.size() != 4));
            CHECK((answer.size() == 5 || room[4] == 0xA5));
        }
    }
    // Where the function fixes more, and after the request has begun to leave, it has no effect.
    modbus::exchange read{framed({1, 3, 0, 0, 0, 1}), byte_buffer{room}, timing, limits};
    CHECK(read.done()); // no room
    modbus::exchange status_byte = made(framed({1, 7}));
    CHECK(status_byte.response_size() == 5);
    status_byte.begin_leaving();
    status_byte.expect_function_alone();
    CHECK(status_byte.response_size() == 5);

    meter<any_line> m;
    modbus::exchange x = made(reset);
    x.expect_function_alone();
    const bus_gaps gaps{};
    for (int steps = 0; steps < 1000 && !x.done(); ++steps) m.port.wait(m.on.step(x, gaps));
    REQUIRE(x.done());
    CHECK(x.status().error() == errc::ok);
    CHECK(byte_list{x.response().begin(), x.response().end()} == reset);
}

TEST_CASE_TEMPLATE("frames of a neighbour that are the function alone keep no response away", Kind, any_line,
                   small_line) {
    meter<Kind> m;
    m.port.device = [](scripted_port& p, const tests::sent_frame&) {
        p.say(2000, with_crc_over({0x02, 0x42}));
        p.say(2000 + 4 * 1146 + 2 * timing.t3_5, framed({1, 3, 2, 0, 9}));
    };
    u16 word[1]{};
    CHECK(m.io.read_words(2, word).error() == errc::ok);
    CHECK(word[0] == 9);
}

TEST_CASE_TEMPLATE("a coil is written by 05 with any value, and its response is one that repeats it", Kind,
                   any_line, small_line) {
    // 5500h toggles the relay of some modules; others take times, in tenths of a second.
    for (const unsigned value : {0x5500u, 0x0200u, 0x0007u, 0xFFFFu, 0xFF00u, 0x0000u}) {
        CAPTURE(value);
        meter<Kind> m;
        const byte_list asked{0x05, 0, 1, static_cast<std::uint8_t>(value >> 8),
                              static_cast<std::uint8_t>(value)};
        byte_list whole{1};
        whole.insert(whole.end(), asked.begin(), asked.end());
        std::array<std::uint8_t, 5> answer{};
        m.answers = framed(whole);
        CHECK(m.io.transact(asked, answer).error() == errc::ok);
        CHECK(m.last() == framed(whole));
        CHECK(byte_list{answer.begin(), answer.end()} == asked);
        ++whole[5];
        m.answers = framed(whole);
        CHECK(m.io.transact(asked, answer).error() == errc::wrong_value);
        meter<Kind> unproven{false};
        --whole[5];
        unproven.answers = framed(whole);
        CHECK(unproven.io.transact(asked, answer).error() == errc::own_echo);
    }
}

} // namespace function_alone_tests
