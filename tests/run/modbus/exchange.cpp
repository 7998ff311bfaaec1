// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response, without a port: what counts as the response, and that nothing else ever does.
// Each byte of a response is made wrong once, and a response is truncated, an exception, or missing.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/exchange.hpp>

#include <tests/support/exchange_runs.hpp>

namespace exchange_tests {

using namespace servobus;
using namespace servobus::modbus;
using namespace tests::exchange_runs;
using tests::byte_list;
using tests::framed;
using tests::operator+;

namespace {

// At compile time: a whole read and a whole write.
constexpr std::int64_t compiled_read(std::uint8_t changed_byte, std::uint8_t change) {
    const auto request = read_frame(1, 0x20AB, 2);
    std::array<std::uint8_t, 9> buffer{};
    exchange x{request, buffer, host, usual};
    x.sent({0});
    auto response = hex("01 03 04 00 64 FF 9C FA 75");
    response.data[changed_byte] = static_cast<std::uint8_t>(response.data[changed_byte] ^ change);
    x.feed(response, {1000});
    x.elapse({200'000});
    if (!x.done() || x.status().error() != errc::ok) return -1;
    return std::int64_t{x.words()[0]} + std::int64_t{x.words()[1]} * 0x1'0000;
}
static_assert(crc16<crc_bitwise>(hex("01 03 04 00 64 FF 9C FA 75")) == 0);
static_assert(compiled_read(0, 0) == 0xFF9C0064);
static_assert(compiled_read(3, 1) == -1);
static_assert(compiled_read(8, 0x80) == -1);

constexpr status compiled_write(bytes response) {
    const auto request = write_frame(1, 0x200E, 8);
    std::array<std::uint8_t, 8> buffer{};
    exchange x{request, buffer, host, usual};
    x.sent({0});
    x.feed(response, {1000});
    x.elapse({200'000});
    return x.status();
}
static_assert(compiled_write(hex("01 06 20 0E 00 08 E2 0F")).error() == errc::ok);
static_assert(compiled_write(hex("01 06 20 0E 00 07 A2 0B")).error() == errc::wrong_value);
static_assert(compiled_write(hex("01 86 02 C3 A1")) == status::sent(errc::exception, 2));

} // namespace

TEST_CASE(
    "a request that is no frame, or that can have no response, ends as bad_argument and is never sent") {
    std::array<std::uint8_t, 256> room{};
    const auto refused = [&](const byte_list& request, std::size_t size = 256) {
        exchange x{request, byte_buffer{room}.first(size), host, usual};
        const bool at_once = x.done() && x.status().error() == errc::bad_argument && !x.was_sent();
        x.sent({0}); // changes nothing
        return at_once && x.done() && !x.was_sent();
    };
    CHECK(refused({}));
    CHECK(refused({1}));
    CHECK(refused({1, 3, 0}));
    CHECK(refused(byte_list(257, 1)));
    for (unsigned node_address = 0; node_address <= 254; ++node_address) {
        byte_list request = framed({static_cast<std::uint8_t>(node_address), 3, 0, 0, 0, 1});
        CHECK(refused(request) ==
              (node_address == 0 || node_address > 247)); // G30: a broadcast read is refused
        request = framed({static_cast<std::uint8_t>(node_address), 4, 0, 0, 0, 1});
        CHECK(refused(request) == (node_address == 0 || node_address > 247));
        request = framed({static_cast<std::uint8_t>(node_address), 6, 0, 0, 0, 1});
        CHECK(refused(request) == (node_address > 247));
    }
    CHECK(!refused(framed({255, 3, 0, 0, 0, 1}))); // on Modbus TCP the peer
    CHECK(refused(framed({1, 3, 0, 0, 0, 0})));
    CHECK(refused(framed({1, 3, 0, 0, 0, 126})));
    CHECK(refused(framed({1, 3, 0, 0, 1, 1})));
    CHECK(refused(framed({1, 3, 0, 0, 0})));
    CHECK(refused(framed({1, 3, 0, 0, 0, 1, 0})));
    CHECK(refused(framed({1, 6, 0, 0, 0})));
    CHECK(refused(read_two, 8));
    CHECK_FALSE(refused(read_two, 9));
    CHECK(refused(write_one, 7));
    CHECK_FALSE(refused(write_one, 8));
    CHECK(exchange{}.done());
}

TEST_CASE("the right response is accepted, whole and byte by byte") {
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        const ended whole = run(p.request, p.response);
        CHECK(whole.why == errc::ok);
        CHECK(whole.response == p.response);
        std::vector<burst> single;
        for (std::size_t i = 0; i < p.response.size(); ++i)
            single.push_back({2000 + 100 * static_cast<std::uint32_t>(i), {p.response[i]}});
        const ended slow = run(p.request, single);
        CHECK(slow.why == errc::ok);
        CHECK(slow.words == whole.words);
    }
    CHECK(run(read_two, two_words).words == std::vector<std::uint16_t>{0x0064, 0xFF9C});
    CHECK(run(write_one, one_done).words.empty());
}

TEST_CASE("G2: a response with any one byte wrong gives no value and no success") {
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        for (std::size_t i = 0; i < p.response.size(); ++i) {
            for (unsigned wrong = 1; wrong <= 255; ++wrong) {
                CAPTURE(i);
                CAPTURE(wrong);
                byte_list response = p.response;
                response[i] = static_cast<std::uint8_t>(response[i] ^ wrong);
                const ended e = run(p.request, response);
                REQUIRE(e.why.error() != errc::ok);
                REQUIRE(e.why.error() != errc::exception);
                REQUIRE(e.words.empty());
            }
        }
    }
}

TEST_CASE("G2: a response with any two adjacent bytes wrong gives no value and no success") {
    const byte_list& response = one_word;
    const response_limits brief{.response = milliseconds(3)};
    for (std::size_t i = 0; i + 1 < response.size(); ++i) {
        for (unsigned wrong = 1; wrong <= 0xFFFF; wrong += 3) {
            byte_list bad = response;
            bad[i] = static_cast<std::uint8_t>(bad[i] ^ (wrong >> 8));
            bad[i + 1] = static_cast<std::uint8_t>(bad[i + 1] ^ (wrong & 0xFFu));
            std::array<std::uint8_t, 7> room{};
            exchange x{read_one, room, host, brief};
            x.sent({0});
            x.feed(bad, {500});
            for (std::uint32_t t = 600; !x.done(); t += 1000) x.elapse({t});
            REQUIRE(x.status().error() != errc::ok);
        }
    }
}

TEST_CASE(
    "G2: each field of a response that differs from the request has its own error, even with a good CRC") {
    CHECK(run(read_one, tests::read_response(2, {0x0960})).why.error() == errc::timeout);
    CHECK(run(read_one, tests::read_response(1, {0x0960}, 0x04)).why.error() == errc::wrong_function);
    CHECK(run(read_one, one_done).why.error() == errc::wrong_function);
    CHECK(run(read_one, two_words).why.error() == errc::wrong_byte_count);
    CHECK(run(read_two, one_word).why.error() == errc::wrong_byte_count);
    CHECK(run(read_one, framed({1, 3, 0})).why.error() == errc::wrong_byte_count);
    CHECK(run(read_one, framed({1, 3, 3, 0, 1, 2})).why.error() == errc::wrong_byte_count);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x89, 0x00, 0x64})).why.error() == errc::wrong_address);
    CHECK(run(write_one, framed({1, 6, 0x21, 0x88, 0x00, 0x64})).why.error() == errc::wrong_address);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x00, 0x65})).why.error() == errc::wrong_value);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x01, 0x64})).why.error() == errc::wrong_value);
    CHECK(run(write_one, many_done).why.error() == errc::wrong_function);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x8A, 0, 2})).why.error() == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 0, 1})).why.error() == errc::wrong_quantity);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 0, 4})).why.error() == errc::wrong_quantity);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 2, 2})).why.error() == errc::wrong_quantity);
    CHECK(run(write_many, write_one).why.error() == errc::wrong_function);
    CHECK(run(read_one, framed({1, 0x83, 2})).why == status::sent(errc::exception, 2));
    CHECK(run(read_one, framed({1, 0x86, 2})).why.error() == errc::wrong_function);
    byte_list bad = one_word;
    bad.back() = static_cast<std::uint8_t>(bad.back() ^ 1u);
    CHECK(run(read_one, bad).why.error() == errc::bad_crc);
}

TEST_CASE("the byte count in place of the quantity is accepted only where the limits of the node allow it") {
    const byte_list quirky = framed({1, 0x10, 0x20, 0x88, 0, 4});
    response_limits tolerant;
    tolerant.echoes_byte_count = true;
    CHECK(run(write_many, quirky, tolerant).why.error() == errc::ok);
    CHECK(run(write_many, many_done, tolerant).why.error() == errc::ok);
    CHECK(run(write_many, quirky).why.error() == errc::wrong_quantity);
    for (unsigned quantity = 0; quantity <= 255; ++quantity) {
        const bool is_ok = quantity == 2 || quantity == 4;
        const byte_list response = framed({1, 0x10, 0x20, 0x88, 0, static_cast<std::uint8_t>(quantity)});
        CHECK((run(write_many, response, tolerant).why.error() == errc::ok) == is_ok);
    }
    // Only the quantity may be the byte count.
    CHECK(run(write_many, framed({1, 0x10, 4, 0x88, 0, 2}), tolerant).why.error() == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 4, 0, 2}), tolerant).why.error() == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 4, 2}), tolerant).why.error() == errc::wrong_quantity);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 1, 4}), tolerant).why.error() == errc::wrong_quantity);
    // And only for function 10h: byte 6 of a request of function 06 belongs to its CRC.
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x00, write_one[6]}), tolerant).why.error() ==
          errc::wrong_value);
}

TEST_CASE("G2: a response truncated anywhere is an error and gives no value") {
    for (const pair& p : pairs()) {
        for (std::size_t n = 0; n < p.response.size(); ++n) {
            CAPTURE(p.name);
            CAPTURE(n);
            const std::vector<burst> cut{{2000, part(p.response, 0, n)}};
            const ended e = run(p.request, cut);
            CHECK(e.why.error() == (n == 0 ? errc::timeout : errc::truncated_response));
            CHECK(e.words.empty());
            CHECK(e.response == part(p.response, 0, n));
            CHECK(run(p.request, cut, strict).why.error() == (n == 0 ? errc::timeout : errc::bad_gap));
            // The rest, too late to belong to it, does not make it valid.
            const ended late = run(p.request, {{2000, part(p.response, 0, n)},
                                               {150'000, part(p.response, n, p.response.size())}});
            CHECK(late.why.error() != errc::ok);
        }
    }
}

TEST_CASE("G2: a request of function 06 that is too long is refused: its first eight bytes are no response") {
    const byte_list request = framed({1, 6, 0x20, 0x0D, 0x00, 0x03, 0xAA, 0xBB});
    std::array<std::uint8_t, 8> room{};
    const auto timing = modbus::timing_at(115200);
    const response_limits limits;
    modbus::exchange x{request, room, timing, limits};
    CHECK(x.done());
    x.sent({0});
    x.feed(bytes{request}.first(8), {100});
    CHECK(x.status().error() == errc::bad_argument);
}

TEST_CASE("no response ends as a timeout, at its limit and not before") {
    for (const std::uint32_t limit : {1u, 10u, 100u, 1000u}) {
        CAPTURE(limit);
        const response_limits p{.response = milliseconds(limit)};
        const ended e = run(read_one, std::vector<burst>{}, host, p);
        CHECK(e.why.error() == errc::timeout);
        CHECK(e.at >= limit * 1000);
        CHECK(e.at <= limit * 1000 + 50);
    }
}

TEST_CASE("`elapse` returns how long nothing will happen, and nothing happens") {
    std::array<std::uint8_t, 16> room{};
    exchange x{read_one, room, host, usual};
    x.sent({500});
    duration left = x.elapse({500});
    CHECK(left == milliseconds(100));
    left = x.elapse({40'500});
    CHECK(left == milliseconds(60));
    x.elapse({100'499});
    CHECK_FALSE(x.done());
    x.elapse({100'500});
    CHECK(x.done());
}

TEST_CASE("`feed` returns how many bytes belonged to the transaction") {
    std::array<std::uint8_t, 16> room{};
    exchange x{read_one, room, host, usual};
    CHECK(x.feed(one_word, {0}) == 0); // nothing before the request was sent
    x.sent({0});
    CHECK(x.feed(bytes{}, {1}) == 0);
    CHECK(x.feed(one_word + byte_list{9, 9, 9}, {2000}) == one_word.size());
    CHECK(x.done());
    CHECK(x.feed(one_word, {3000}) == 0);
    CHECK(x.response().size() == one_word.size());
}

TEST_CASE("a function code above 7Fh is no request, since its response could not be distinguished from an "
          "exception") {
    for (unsigned code = 0; code <= 255; ++code) {
        std::array<std::uint8_t, 16> room{};
        const byte_list request = framed({1, static_cast<std::uint8_t>(code), 0x20, 0x88, 0x00, 0x01});
        const exchange x{request, room, host, usual};
        CAPTURE(code);
        CHECK(x.done() == (code == 0 || code > 0x7F));
    }
}

TEST_CASE("G12: every exception number reaches the caller unchanged, for every function") {
    for (const pair& p : pairs()) {
        for (unsigned number = 0; number <= 255; ++number) {
            const ended e =
                run(p.request, tests::exception_response(1, p.request[1], static_cast<std::uint8_t>(number)));
            const errc why = number == 5 ? errc::acknowledged : errc::exception;
            REQUIRE(e.why == status::sent(why, static_cast<std::uint8_t>(number)));
            REQUIRE(e.words.empty());
        }
        byte_list bad = tests::exception_response(1, p.request[1], 2);
        for (std::size_t i = 1; i < bad.size(); ++i) {
            byte_list wrong = bad;
            wrong[i] = static_cast<std::uint8_t>(wrong[i] ^ 0x40u);
            REQUIRE(run(p.request, wrong).why.error() != errc::exception);
            REQUIRE(run(p.request, wrong).why.error() != errc::ok);
        }
    }
}

TEST_CASE("the response may be stored in the memory of the request") {
    for (const pair& p : pairs()) {
        for (const bool with_foreign : {false, true}) {
            byte_list memory = p.request;
            memory.resize(32);
            exchange x{bytes{memory}.first(p.request.size()), memory, host, usual};
            x.sent({0});
            const byte_list in_front = with_foreign ? tests::read_response(9, {1, 2, 3}) : byte_list{};
            for (const std::uint8_t b : in_front + p.response) x.feed(b, {1000});
            CHECK(x.done());
            CHECK(x.status().error() == errc::ok);
            CHECK(same_bytes(x.response(), p.response));
        }
    }
}

TEST_CASE("G30: a broadcast is done after the turnaround, whatever is received") {
    const byte_list all = framed({0, 6, 0x20, 0x0E, 0, 7});
    for (const byte_list& heard : {byte_list{}, all, framed({1, 6, 0x20, 0x0E, 0, 7}), byte_list(40, 0x55)}) {
        const ended e = run(all, std::vector<burst>{{2000, heard}});
        CHECK(e.why.error() == errc::ok);
        CHECK(e.at >= 10'000);
        CHECK(e.at <= 10'050);
        CHECK(e.response.empty());
    }
}

TEST_CASE("an aborted exchange keeps its first error") {
    std::array<std::uint8_t, 16> room{};
    exchange x{read_one, room, host, usual};
    x.abort(errc::partial_send, true);
    CHECK(x.done());
    CHECK(x.was_sent());
    CHECK(x.status().error() == errc::partial_send);
    x.abort(errc::port_lost, false);
    CHECK(x.status().error() == errc::partial_send);
    exchange y{read_one, room, host, usual};
    y.abort(errc::send_failed, false);
    CHECK_FALSE(y.was_sent());
}

TEST_CASE("the response to a function without a known length is as long as its buffer") {
    const byte_list request = framed({1, 0x41, 7});
    const byte_list response = framed({1, 0x41, 1, 2, 3});
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size()).why.error() ==
          errc::ok);
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size() + 1).why.error() ==
          errc::truncated_response);
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size() - 1).why.error() ==
          errc::bad_crc);
    CHECK(
        run(request, std::vector<burst>{{2000, tests::exception_response(1, 0x41, 9)}}, host, usual, 8).why ==
        status::sent(errc::exception, 9));
}

TEST_CASE("has_received() is true after a response in one piece, as after one byte by byte") {
    const auto request = read_frame(1, 0x20AB, 2);
    const auto response = hex("01 03 04 00 64 FF 9C FA 75");
    for (const std::size_t piece : {response.size, std::size_t{1}}) {
        CAPTURE(piece);
        std::array<std::uint8_t, 9> buffer{};
        exchange x{request, buffer, host, usual};
        CHECK_FALSE(x.has_received());
        x.sent({0});
        CHECK_FALSE(x.has_received());
        for (std::size_t at = 0; at < response.size; at += piece)
            x.feed(bytes{response}.subspan(at).first(piece), {1000});
        CHECK(x.status() == errc::ok);
        CHECK(x.has_received());
    }
}

TEST_CASE("G2: after bytes that are not the request's while it leaves a response is taken after a gap only") {
    const auto request = read_frame(1, 0x20AB, 2);
    const auto response = hex("01 03 04 00 64 FF 9C FA 75");
    const auto gap = microseconds(host.longest_gap(1).us + 1);
    const auto answered = [&](bytes while_leaving, duration wait) {
        std::array<std::uint8_t, 9> buffer{};
        exchange x{request, buffer, host, usual};
        x.begin_leaving();
        x.pass_while_leaving(while_leaving, {500});
        x.sent({600});
        x.elapse(instant{500} + wait);
        x.feed(bytes{response}, instant{500} + wait);
        return x.done() && x.status() == errc::ok;
    };
    const bytes sent{request};
    const byte_list whole{sent.begin(), sent.end()};
    const byte_list part{sent.begin(), sent.begin() + 3};
    const byte_list glitches{0x00, 0xFF, 0x01, 0x00, 0x03, 0xFF};
    for (const byte_list& echo : {byte_list{}, whole, part, glitches})
        CHECK(answered(echo, microseconds(150)));
    for (const byte_list& other : {byte_list{0x09}, part + byte_list{0x09}, whole + byte_list{0x01},
                                   byte_list{0x03}, byte_list{0x09, 0x01, 0x03}}) {
        CAPTURE(other.size());
        CHECK_FALSE(answered(other, microseconds(100)));
        CHECK_FALSE(answered(other, microseconds(gap.us - 1)));
        CHECK(answered(other, gap));
    }
    SUBCASE("a garbled byte is one of the request's") {
        std::array<std::uint8_t, 9> buffer{};
        exchange x{request, buffer, host, usual};
        x.begin_leaving();
        x.pass_while_leaving(bytes{part}, {500});
        x.pass_garbled();
        x.pass_while_leaving(bytes{whole}.subspan(4), {500});
        x.sent({600});
        CHECK_FALSE(x.has_received());
        x.feed(bytes{response}, {700});
        CHECK(x.status() == errc::ok);
    }
    SUBCASE("bytes before it begins to leave have no effect") {
        std::array<std::uint8_t, 9> buffer{};
        exchange x{request, buffer, host, usual};
        x.pass_while_leaving(bytes{response}, {500});
        x.begin_leaving();
        x.sent({600});
        x.feed(bytes{response}, {700});
        CHECK(x.status() == errc::ok);
    }
    SUBCASE("a broadcast awaits its turnaround all the same") {
        const auto all = modbus::write_frame(modbus::broadcast, 0x2088, {0, 0});
        exchange x{all, {}, host, usual};
        x.begin_leaving();
        x.pass_while_leaving(bytes{part}, {500});
        x.sent({600});
        CHECK(x.state() == exchange::phase::turnaround);
    }
}

TEST_CASE("G30: a broadcast awaits no function alone, and a gateway's refusal only where it has room") {
    for (const std::size_t room : {4u, 8u}) {
        CAPTURE(room);
        const byte_list request = framed({0x00, 0x42});
        std::array<std::uint8_t, 8> buffer{};
        exchange x{request, byte_buffer{buffer}.first(room), host, usual};
        REQUIRE(x.state() == exchange::phase::ready);
        x.expect_function_alone();
        CHECK(x.response_size() == (room < 5 ? 0 : room));
        x.sent_to_gateway({1000});
        CHECK(x.state() == (room < 5 ? exchange::phase::turnaround : exchange::phase::awaiting));
    }
}

} // namespace exchange_tests
