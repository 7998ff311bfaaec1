// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random requests and responses of the functions whose response is fixed by its request, on both lines: a call of
// `transact` succeeds where a judge that is written apart from the library calls the response valid, and nowhere else.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

#include <servobus/client/open_responses.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/client_rig.hpp>
#include <tests/support/functions_reference.hpp>
#include <tests/support/random_functions.hpp>

namespace transact_functions_tests {

using namespace servobus;
using namespace tests::typed;
using functions_reference::verdict;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::random_functions::maker;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

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
    static constexpr modbus::rtu_timing strict = modbus::timing_at(115200, modbus::timing_mode::strict);
    using type = servobus::line<tests::waiting_scripted_port, counters, unechoed, modbus::open_lengths>;
    static type on(tests::waiting_scripted_port& port) { return type{port, strict}; }
};

bool is_judged_by_the_line(const byte_list& pdu) {
    if (pdu[0] == 8) return functions_reference::word(pdu, 1) == 0;
    return pdu[0] <= 6 || pdu[0] == 15 || pdu[0] == 16 || pdu[0] == 22 || pdu[0] == 23;
}
/// True for the echo of a request, and for one with zeros behind it, which a driver sends and a CRC does not notice.
bool is_echo_with_zeros(const byte_list& asked, const byte_list& response) {
    byte_list echo = framed(byte_list{1} + asked);
    const byte_list frame = framed(byte_list{1} + response);
    if (frame.size() < echo.size()) return false;
    echo.resize(frame.size());
    return echo == frame;
}
/// The frame with a PDU of so many bytes, if its CRC is right.
byte_list cut_to(std::size_t pdu, byte_list frame) {
    if (frame.size() < pdu + 3) return {};
    frame.resize(pdu + 3);
    return framed({frame.begin(), frame.end() - 2}) == frame ? frame : byte_list{};
}
/// The length of the valid response, as the standard gives it.
std::size_t length_of_response(const byte_list& pdu) {
    const unsigned quantity = pdu.size() >= 5 ? functions_reference::word(pdu, 3) : 0;
    if (pdu[0] < 3) return 2 + (quantity + 7) / 8;
    if (pdu[0] < 5 || pdu[0] == 23) return 2 + std::size_t{2} * quantity;
    return pdu[0] == 8 || pdu[0] == 22 ? pdu.size() : 5;
}
} // namespace

TEST_CASE_TEMPLATE("G1, G2: a response to any function is accepted where it is what the request demands",
                   Kind, any_line, small_line) {
    maker random{26};
    std::map<unsigned, unsigned> accepted;
    std::map<unsigned, unsigned> refused;
    for (unsigned round = 0; round < 30'000; ++round) {
        CAPTURE(round);
        const byte_list asked = random.request();
        if (functions_reference::exception_of(asked) != 0 || !is_judged_by_the_line(asked)) continue;
        const std::size_t length = length_of_response(asked);
        if (asked.size() > 252 || length > 252) continue; // more than a blocking line has
        byte_list response = random.response(asked);
        if (!random.one_in(3)) response = random.mutated(response);
        if (response.size() > 253) continue;

        tests::waiting_scripted_port port;
        typename Kind::type on = Kind::on(port);
        client device_at_1{on, node<device>{1}};
        port.device = [&](scripted_port& p, const tests::sent_frame& f) {
            if (f.data == framed(byte_list{1} + asked)) p.say(500, framed(byte_list{1} + response));
        };
        std::array<std::uint8_t, 253> room{};
        const status why = device_at_1.transact(asked, byte_buffer{room}.first(length));

        const verdict judged = functions_reference::judge(asked, response);
        // A line leaves the padding of coils to those who read them.
        const bool has_padding_only = asked[0] < 3 && judged == verdict::other_content;
        const bool is_valid = judged == verdict::valid || has_padding_only;
        // Nothing has ruled out an echo on this line yet.
        const bool may_be_echo = response == asked;
        CAPTURE(asked);
        CAPTURE(response);
        const bool is_accepted = why.error() == errc::ok;
        REQUIRE(is_accepted == (is_valid && !may_be_echo));
        if (judged == verdict::exception)
            REQUIRE(why.error() == (why.exception() == 5 ? errc::acknowledged : errc::exception));
        if (is_valid && may_be_echo) REQUIRE(why.error() == errc::own_echo);
        ++(why ? accepted : refused)[asked[0]];
    }
    for (const unsigned code : {1u, 2u, 3u, 4u, 15u, 16u, 23u}) CHECK(accepted[code] > 100);
    for (const unsigned code : {1u, 2u, 3u, 4u, 5u, 6u, 8u, 15u, 16u, 22u, 23u}) CHECK(refused[code] > 100);
}

TEST_CASE_TEMPLATE("a response of any length is accepted where the function's rule ends it", Kind,
                   any_open_line, small_open_line, strict_open_line) {
    maker random{27};
    std::map<unsigned, unsigned> accepted;
    std::map<unsigned, unsigned> refused;
    for (unsigned round = 0; round < 30'000; ++round) {
        CAPTURE(round);
        const byte_list asked = random.request();
        if (functions_reference::exception_of(asked) != 0 || is_judged_by_the_line(asked)) continue;
        byte_list response = random.response(asked);
        if (!random.one_in(3)) response = random.mutated(response);
        if (response.empty() || response.size() > 252) continue;

        tests::waiting_scripted_port port;
        typename Kind::type on = Kind::on(port);
        client device_at_1{on, node<device>{1}};
        port.device = [&](scripted_port& p, const tests::sent_frame& f) {
            if (f.data == framed(byte_list{1} + asked)) p.say(500, framed(byte_list{1} + response));
        };
        std::array<std::uint8_t, 253> room{};
        room.fill(0xA5);
        const result<bytes> answer = device_at_1.transact(asked, room, modbus::length_rule::of_function());

        const verdict judged = functions_reference::judge(asked, response);
        // A line takes no byte behind the response. What it leaves may be the CRC of the rest, once in 65536.
        const byte_list whole =
            cut_to(functions_reference::least(asked, response), framed(byte_list{1} + response));
        const bool is_whole = response[0] == asked[0] && !whole.empty();
        const bool may_be_echo = is_echo_with_zeros(asked, response);
        const bool is_accepted = static_cast<bool>(answer);
        REQUIRE(is_accepted == (is_whole && !may_be_echo));
        if (judged == verdict::valid && !may_be_echo) REQUIRE(is_accepted);
        if (judged == verdict::exception)
            REQUIRE(answer.error() ==
                    (answer.status().exception() == 5 ? errc::acknowledged : errc::exception));
        if (answer) {
            REQUIRE(framed(byte_list{1} + byte_list{answer->begin(), answer->end()}) == whole);
            REQUIRE((answer->size() == room.size() || room[answer->size()] == 0xA5));
        } else {
            REQUIRE(room == [] {
                std::array<std::uint8_t, 253> untouched{};
                untouched.fill(0xA5);
                return untouched;
            }());
        }
        ++(answer ? accepted : refused)[asked[0]];
    }
    for (const unsigned code : {7u, 8u, 11u, 12u, 17u, 24u, 43u}) {
        CAPTURE(code);
        CHECK(accepted[code] > 100);
        CHECK(refused[code] > 100);
    }
}

TEST_CASE_TEMPLATE("a user-defined function ends by the caller's rule", Kind, any_open_line, small_open_line,
                   strict_open_line) {
    using modbus::length_rule;
    tests::waiting_scripted_port port;
    typename Kind::type on = Kind::on(port);
    client drive{on, node<device>{1}};
    byte_list response;
    port.device = [&](scripted_port& p, const tests::sent_frame&) {
        p.say(500, framed(byte_list{1} + response));
    };
    std::array<std::uint8_t, 16> room{};
    const byte_list asked{0x41, 7};
    const auto ask = [&](const byte_list& pdu, length_rule rule) {
        response = pdu;
        return drive.transact(asked, room, rule);
    };
    const auto is = [](const result<bytes>& answer, const byte_list& pdu) {
        return answer && byte_list{answer->begin(), answer->end()} == pdu;
    };
    CHECK(is(ask({0x41, 9, 8, 3}, length_rule::fixed(4)), {0x41, 9, 8, 3}));
    CHECK(ask({0x41, 9, 8}, length_rule::fixed(4)).error() >= errc::truncated_response);
    CHECK(!ask({0x41, 9, 8, 3, 4}, length_rule::fixed(4)));
    CHECK(is(ask({0x41, 9, 2, 3, 4}, length_rule::counted(2)), {0x41, 9, 2, 3, 4}));
    CHECK(is(ask({0x41, 9, 0}, length_rule::counted(2)), {0x41, 9, 0}));
    CHECK(!ask({0x41, 9, 3, 3, 4}, length_rule::counted(2)));
    CHECK(is(ask({0x41, 9, 3, 3, 4}, length_rule::until_gap()), {0x41, 9, 3, 3, 4}));
    CHECK(is(ask({0x41, 1}, length_rule::until_gap()), {0x41, 1}));
    CHECK(is(ask(byte_list{0x41} + byte_list(15, 6), length_rule::until_gap()),
             byte_list{0x41} + byte_list(15, 6)));
    // More than there is room for.
    CHECK(ask(byte_list{0x41, 9, 14} + byte_list(14, 1), length_rule::counted(2)).error() == errc::too_long);
    CHECK(!ask(byte_list{0x41} + byte_list(16, 6), length_rule::until_gap()));
    CHECK(is(ask(byte_list{0x41, 9, 13} + byte_list(13, 1), length_rule::counted(2)),
             byte_list{0x41, 9, 13} + byte_list(13, 1)));
    // Exceptions have their length under every rule.
    for (const length_rule rule :
         {length_rule::fixed(9), length_rule::counted(1), length_rule::until_gap()}) {
        const result<bytes> refused = ask({0xC1, 2}, rule);
        CHECK(refused.error() == errc::exception);
        CHECK(refused.status().exception() == 2);
    }
    // A rule that is none, and one that the request's function does not need.
    const std::size_t sent = port.frames.size();
    CHECK(drive.transact(asked, room, length_rule::fixed(0)).error() == errc::bad_argument);
    CHECK(drive.transact(asked, room, length_rule::fixed(254)).error() == errc::bad_argument);
    CHECK(drive.transact(asked, room, length_rule::counted(0)).error() == errc::bad_argument);
    CHECK(drive.transact(asked, room, length_rule::counted(253)).error() == errc::bad_argument);
    // A request that is none, room for no response, and a node that cannot be.
    const length_rule two = length_rule::fixed(2);
    CHECK(drive.transact(bytes{}, room, two).error() == errc::bad_argument);
    CHECK(drive.transact(byte_list(254, 0x41), room, two).error() == errc::bad_argument);
    CHECK(drive.transact(asked, byte_buffer{}, two).error() == errc::bad_argument);
    client nobody{on, node<device>{248}};
    CHECK(nobody.transact(asked, room, two).error() == errc::bad_argument);
    CHECK(port.frames.size() == sent);
    response = {1, 1, 0x05}; // the request tells the length, whatever the rule
    CHECK(is(drive.transact(byte_list{1, 0, 0, 0, 3}, room, length_rule::of_function()), {1, 1, 0x05}));
    response = {15, 0, 3, 0, 9};
    CHECK(is(drive.transact(byte_list{15, 0, 3, 0, 9, 2, 1, 1}, room, length_rule::of_function()),
             {15, 0, 3, 0, 9}));
    response = {23, 2, 0, 7};
    CHECK(is(drive.transact(byte_list{23, 0, 0, 0, 1, 0, 2, 0, 1, 2, 0, 5}, room, length_rule::until_gap()),
             {23, 2, 0, 7}));
    CHECK(drive.transact(byte_list{1, 0, 0, 0, 0}, room, length_rule::of_function()).error() ==
          errc::bad_argument);
    CHECK(drive.transact(byte_list{1, 0, 0, 0, 200}, room, length_rule::of_function()).error() ==
          errc::bad_argument);
    response = {3, 2, 0, 9};
    CHECK(is(drive.transact(byte_list{3, 0, 0, 0, 1}, room, length_rule::fixed(9)), {3, 2, 0, 9}));
    response = {3, 4, 0, 9, 0, 0};
    CHECK(drive.transact(byte_list{3, 0, 0, 0, 1}, room, length_rule::fixed(6)).error() ==
          errc::wrong_byte_count);
}

} // namespace transact_functions_tests
