// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response, without a port: what counts as the response, and that nothing else ever does.
// Every byte of a response is wrong in turn, cut, late, doubled, preceded and followed by rubbish.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/server.hpp>

#include <tests/support/scripted_port.hpp>

using namespace servobus;
using namespace servobus::modbus;
using tests::byte_list;
using tests::framed;
using tests::operator+;

namespace {

constexpr rtu_timing host = timing_at(115200);
constexpr rtu_timing strict = timing_at(9600, timing_mode::strict);
constexpr response_limits usual{};

// By the compiler: a whole read and a whole write.
constexpr std::int64_t compiled_read(std::uint8_t changed_byte, std::uint8_t change) {
    const auto request = read_frame(1, 0x20AB, 2);
    std::array<std::uint8_t, 9> buffer{};
    exchange x{request, buffer, host, usual};
    x.sent({0});
    auto response = hex("01 03 04 00 64 FF 9C FA 75");
    response.data[changed_byte] = static_cast<std::uint8_t>(response.data[changed_byte] ^ change);
    x.feed(response, {1000});
    x.elapse({200'000});
    if (!x.done() || x.why().code != errc::ok) return -1;
    return std::int64_t{x.words()[0]} + std::int64_t{x.words()[1]} * 0x1'0000;
}
static_assert(crc16<crc_bitwise>(hex("01 03 04 00 64 FF 9C FA 75")) == 0);
static_assert(compiled_read(0, 0) == 0xFF9C0064);
static_assert(compiled_read(3, 1) == -1);
static_assert(compiled_read(8, 0x80) == -1);

constexpr failure compiled_write(bytes response) {
    const auto request = write_frame(1, 0x200E, 8);
    std::array<std::uint8_t, 8> buffer{};
    exchange x{request, buffer, host, usual};
    x.sent({0});
    x.feed(response, {1000});
    x.elapse({200'000});
    return x.why();
}
static_assert(compiled_write(hex("01 06 20 0E 00 08 E2 0F")).code == errc::ok);
static_assert(compiled_write(hex("01 06 20 0E 00 07 A2 0B")).code == errc::wrong_value);
static_assert(compiled_write(hex("01 86 02 C3 A1")) == failure{errc::exception, 2});

/// What a whole exchange came to.
struct ended {
    failure why;
    std::vector<std::uint16_t> words;
    byte_list response;
    unsigned foreign = 0;
    std::uint32_t at = 0; // when it ended, from the request's last bit on
};

/// Feeds `arrived` as bursts, each `pause` us behind the one before, the first after `first` us.
struct burst {
    std::uint32_t at;
    byte_list data;
};

ended run(const byte_list& request, const std::vector<burst>& bursts, const rtu_timing& timing = host,
          const response_limits& limits = usual, std::size_t room = 256) {
    byte_list memory(room + 32, 0xA5);
    exchange x{request, byte_buffer{memory}.subspan(16, room), timing, limits};
    const instant start{0xFFFF'F000u}; // the clock wraps on the way
    ended result;
    x.sent(start);
    std::uint32_t time = 0;
    const auto rest_until = [&](std::uint32_t until) {
        for (; time < until && !x.done(); time += 50) x.elapse(start + microseconds(time));
        if (!x.done()) time = until;
    };
    for (const burst& b : bursts) {
        rest_until(b.at);
        if (x.done()) break;
        x.feed(b.data, start + microseconds(time));
        if (!x.done()) x.elapse(start + microseconds(time));
    }
    rest_until(2'000'000);
    REQUIRE(x.done());
    result.at = time;
    result.why = x.why();
    result.foreign = x.other_unit_frames();
    REQUIRE(x.response().size() <= room);
    result.response.assign(x.response().begin(), x.response().end());
    for (std::size_t i = 0; i < x.words().size(); ++i) result.words.push_back(x.words()[i]);
    for (std::size_t i = 0; i < 16; ++i) {
        REQUIRE(memory[i] == 0xA5);
        REQUIRE(memory[memory.size() - 1 - i] == 0xA5);
    }
    return result;
}

ended run(const byte_list& request, const byte_list& response, const response_limits& limits = usual) {
    return run(request, std::vector<burst>{{2000, response}}, host, limits);
}

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list read_two = framed({0x01, 0x03, 0x20, 0xAB, 0x00, 0x02});
const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
const byte_list write_many = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04, 0x00, 0x64, 0x00, 0x64});

const byte_list one_word = tests::read_response(1, {0x0960});
const byte_list two_words = tests::read_response(1, {0x0064, 0xFF9C});
const byte_list one_done = write_one;
const byte_list many_done = framed({0x01, 0x10, 0x20, 0x88, 0x00, 0x02});

struct pair {
    const char* name;
    byte_list request;
    byte_list response;
};
const std::vector<pair>& pairs() {
    static const std::vector<pair> all{{"read of one", read_one, one_word},
                                       {"read of two", read_two, two_words},
                                       {"write of one", write_one, one_done},
                                       {"write of two", write_many, many_done}};
    return all;
}

byte_list part(const byte_list& all, std::size_t from, std::size_t to) {
    return {all.begin() + static_cast<std::ptrdiff_t>(from), all.begin() + static_cast<std::ptrdiff_t>(to)};
}

} // namespace

TEST_CASE(
    "a request that is no frame, or that nobody could answer, ends as a bad argument and is never sent") {
    std::array<std::uint8_t, 256> room{};
    const auto refused = [&](const byte_list& request, std::size_t size = 256) {
        exchange x{request, byte_buffer{room}.first(size), host, usual};
        const bool at_once = x.done() && x.why().code == errc::bad_argument && !x.was_sent();
        x.sent({0}); // changes nothing
        return at_once && x.done() && !x.was_sent();
    };
    CHECK(refused({}));
    CHECK(refused({1}));
    CHECK(refused({1, 3, 0}));
    CHECK(refused(byte_list(257, 1)));
    for (unsigned unit = 0; unit <= 255; ++unit) {
        byte_list request = framed({static_cast<std::uint8_t>(unit), 3, 0, 0, 0, 1});
        CHECK(refused(request) == (unit == 0 || unit > 247)); // G30: a broadcast read is refused
        request = framed({static_cast<std::uint8_t>(unit), 4, 0, 0, 0, 1});
        CHECK(refused(request) == (unit == 0 || unit > 247));
        request = framed({static_cast<std::uint8_t>(unit), 6, 0, 0, 0, 1});
        CHECK(refused(request) == (unit > 247));
    }
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

TEST_CASE("the right response is taken, whole and byte by byte") {
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        const ended whole = run(p.request, p.response);
        CHECK(whole.why == failure{});
        CHECK(whole.response == p.response);
        std::vector<burst> single;
        for (std::size_t i = 0; i < p.response.size(); ++i)
            single.push_back({2000 + 100 * static_cast<std::uint32_t>(i), {p.response[i]}});
        const ended slow = run(p.request, single);
        CHECK(slow.why == failure{});
        CHECK(slow.words == whole.words);
    }
    CHECK(run(read_two, two_words).words == std::vector<std::uint16_t>{0x0064, 0xFF9C});
    CHECK(run(write_one, one_done).words.empty());
}

TEST_CASE("G2: with any one byte of the response wrong there is no value and no success") {
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        for (std::size_t i = 0; i < p.response.size(); ++i) {
            for (unsigned wrong = 1; wrong <= 255; ++wrong) {
                CAPTURE(i);
                CAPTURE(wrong);
                byte_list response = p.response;
                response[i] = static_cast<std::uint8_t>(response[i] ^ wrong);
                const ended e = run(p.request, response);
                REQUIRE(e.why.code != errc::ok);
                REQUIRE(e.why.code != errc::exception);
                REQUIRE(e.words.empty());
            }
        }
    }
}

TEST_CASE("G2: with any two neighbouring bytes wrong there is no value and no success") {
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
            REQUIRE(x.why().code != errc::ok);
        }
    }
}

TEST_CASE(
    "G2: each field of a response that disagrees with the request has its own error, even with a good CRC") {
    CHECK(run(read_one, tests::read_response(2, {0x0960})).why.code == errc::timeout);
    CHECK(run(read_one, tests::read_response(2, {0x0960})).foreign == 1);
    CHECK(run(read_one, tests::read_response(1, {0x0960}, 0x04)).why.code == errc::wrong_function);
    CHECK(run(read_one, one_done).why.code == errc::wrong_function);
    CHECK(run(read_one, two_words).why.code == errc::wrong_byte_count);
    CHECK(run(read_two, one_word).why.code == errc::wrong_byte_count);
    CHECK(run(read_one, framed({1, 3, 0})).why.code == errc::wrong_byte_count);
    CHECK(run(read_one, framed({1, 3, 3, 0, 1, 2})).why.code == errc::wrong_byte_count);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x89, 0x00, 0x64})).why.code == errc::wrong_address);
    CHECK(run(write_one, framed({1, 6, 0x21, 0x88, 0x00, 0x64})).why.code == errc::wrong_address);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x00, 0x65})).why.code == errc::wrong_value);
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x01, 0x64})).why.code == errc::wrong_value);
    CHECK(run(write_one, many_done).why.code == errc::wrong_function);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x8A, 0, 2})).why.code == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 0, 1})).why.code == errc::wrong_quantity);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 0, 4})).why.code == errc::wrong_quantity);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 2, 2})).why.code == errc::wrong_quantity);
    CHECK(run(write_many, write_one).why.code == errc::wrong_function);
    CHECK(run(read_one, framed({1, 0x83, 2})).why == failure{errc::exception, 2});
    CHECK(run(read_one, framed({1, 0x86, 2})).why.code == errc::wrong_function);
    byte_list bad = one_word;
    bad.back() = static_cast<std::uint8_t>(bad.back() ^ 1u);
    CHECK(run(read_one, bad).why.code == errc::bad_crc);
}

TEST_CASE(
    "the byte count in place of the quantity is accepted from a drive with that quirk, and from no other") {
    const byte_list quirky = framed({1, 0x10, 0x20, 0x88, 0, 4});
    response_limits forgiving;
    forgiving.echoes_byte_count = true;
    CHECK(run(write_many, quirky, forgiving).why.code == errc::ok);
    CHECK(run(write_many, many_done, forgiving).why.code == errc::ok);
    CHECK(run(write_many, quirky).why.code == errc::wrong_quantity);
    for (unsigned quantity = 0; quantity <= 255; ++quantity) {
        const bool is_ok = quantity == 2 || quantity == 4;
        const byte_list response = framed({1, 0x10, 0x20, 0x88, 0, static_cast<std::uint8_t>(quantity)});
        CHECK((run(write_many, response, forgiving).why.code == errc::ok) == is_ok);
    }
    // It is of that one place only.
    CHECK(run(write_many, framed({1, 0x10, 4, 0x88, 0, 2}), forgiving).why.code == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 4, 0, 2}), forgiving).why.code == errc::wrong_address);
    CHECK(run(write_many, framed({1, 0x10, 0x20, 0x88, 4, 2}), forgiving).why.code == errc::wrong_quantity);
    // And of function 10h only: byte 6 of a request of function 06 is of its CRC.
    CHECK(run(write_one, framed({1, 6, 0x20, 0x88, 0x00, write_one[6]}), forgiving).why.code ==
          errc::wrong_value);
}

TEST_CASE("G2: a response cut anywhere is an error and gives no value") {
    for (const pair& p : pairs()) {
        for (std::size_t n = 0; n < p.response.size(); ++n) {
            CAPTURE(p.name);
            CAPTURE(n);
            const std::vector<burst> cut{{2000, part(p.response, 0, n)}};
            const ended e = run(p.request, cut);
            CHECK(e.why.code == (n == 0 ? errc::timeout : errc::truncated_response));
            CHECK(e.words.empty());
            CHECK(e.response == part(p.response, 0, n));
            CHECK(run(p.request, cut, strict).why.code == (n == 0 ? errc::timeout : errc::bad_gap));
            // The rest, too late to belong to it, does not make it good.
            const ended late = run(p.request, {{2000, part(p.response, 0, n)},
                                               {150'000, part(p.response, n, p.response.size())}});
            CHECK(late.why.code != errc::ok);
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
    CHECK(x.why().code == errc::bad_argument);
}

TEST_CASE("no response ends as a time-out, at its limit and not before") {
    for (const std::uint32_t limit : {1u, 10u, 100u, 1000u}) {
        CAPTURE(limit);
        const response_limits p{.response = milliseconds(limit)};
        const ended e = run(read_one, std::vector<burst>{}, host, p);
        CHECK(e.why.code == errc::timeout);
        CHECK(e.at >= limit * 1000);
        CHECK(e.at <= limit * 1000 + 50);
    }
}

TEST_CASE("`elapse` tells how long nothing will happen, and nothing does") {
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

TEST_CASE("G5: up to k leading 00 or FF bytes are forgiven, one more is not") {
    for (const unsigned k : {0u, 1u, 4u, 9u}) {
        response_limits p;
        p.leading_bytes = static_cast<std::uint8_t>(k);
        for (unsigned n = 0; n <= 12; ++n) {
            for (const std::uint8_t value : std::array<std::uint8_t, 2>{0x00, 0xFF}) {
                CAPTURE(k);
                CAPTURE(n);
                CAPTURE(value);
                const byte_list lead(n, value);
                for (const pair& q : pairs()) {
                    const ended e = run(q.request, lead + q.response, p);
                    CHECK((e.why.code == errc::ok) == (n <= k));
                    if (n > k) CHECK(e.why.code == errc::timeout);
                }
            }
        }
    }
}

TEST_CASE("G5: any other byte in front of a response is not forgiven, unless it is over before a silence") {
    for (unsigned value = 1; value <= 254; ++value) {
        CAPTURE(value);
        const byte_list lead{static_cast<std::uint8_t>(value)};
        CHECK(run(read_one, lead + one_word).why.code != errc::ok);
        if (value == 1) continue; // looks like the beginning of the response
        const ended apart = run(read_one, {{2000, lead}, {30'000, one_word}});
        CHECK(apart.why.code == errc::ok);
        CHECK(apart.words == std::vector<std::uint16_t>{0x0960});
    }
}

TEST_CASE("G5: leading bytes make nothing acceptable that is not") {
    for (std::size_t n = 0; n <= 4; ++n) {
        const byte_list lead(n, 0x00);
        for (std::size_t i = 0; i < one_word.size(); ++i) {
            for (unsigned wrong = 1; wrong <= 255; ++wrong) {
                byte_list response = one_word;
                response[i] = static_cast<std::uint8_t>(response[i] ^ wrong);
                const ended e = run(read_one, lead + response);
                REQUIRE(e.why.code != errc::ok);
                REQUIRE(e.words.empty());
            }
        }
    }
}

TEST_CASE("G6: trailing bytes change no value, however many and whatever they are") {
    tests::dice random{6};
    for (const pair& p : pairs()) {
        const ended plain = run(p.request, p.response);
        for (const std::size_t n :
             {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{64}, std::size_t{300}}) {
            byte_list zeros(n, 0x00);
            byte_list ones(n, 0xFF);
            byte_list noise(n);
            for (auto& b : noise) b = random.byte();
            for (const byte_list& tail : {zeros, ones, noise, p.response}) {
                const ended e = run(p.request, p.response + tail);
                CHECK(e.why.code == errc::ok);
                CHECK(e.words == plain.words);
                CHECK(e.response == p.response);
            }
        }
    }
}

TEST_CASE("G6: a frame ends by its count, not where its CRC happens to fit") {
    // The words are such that the CRC fits after the first word already.
    const byte_list short_frame = framed({1, 3, 4, 0x12, 0x34});
    const auto crc = static_cast<std::uint16_t>(short_frame[5] << 8 | short_frame[6]);
    const byte_list whole = tests::read_response(1, {0x1234, crc});
    REQUIRE(tests::crc_of(part(whole, 0, 7)) == 0);
    CHECK(run(read_two, whole).words == std::vector<std::uint16_t>{0x1234, crc});
    CHECK(run(read_two, part(whole, 0, 7)).why.code == errc::truncated_response);
}

TEST_CASE("feed says how many bytes were the transaction's own") {
    std::array<std::uint8_t, 16> room{};
    exchange x{read_one, room, host, usual};
    CHECK(x.feed(one_word, {0}) == 0); // nothing before it was sent
    x.sent({0});
    CHECK(x.feed(bytes{}, {1}) == 0);
    CHECK(x.feed(one_word + byte_list{9, 9, 9}, {2000}) == one_word.size());
    CHECK(x.done());
    CHECK(x.feed(one_word, {3000}) == 0);
    CHECK(x.response().size() == one_word.size());
}

TEST_CASE(
    "G7: in host timing a response cut at any point, with pauses up to the limit, is the same response") {
    const auto limit = static_cast<std::uint32_t>(host.inter_byte.us);
    for (const pair& p : pairs()) {
        const ended whole = run(p.request, p.response);
        for (std::size_t cut = 1; cut < p.response.size(); ++cut) {
            for (const std::uint32_t pause : {1u, 1000u, 16'000u, limit - 50, limit}) {
                CAPTURE(p.name);
                CAPTURE(cut);
                CAPTURE(pause);
                const ended e = run(p.request, {{2000, part(p.response, 0, cut)},
                                                {2000 + pause, part(p.response, cut, p.response.size())}});
                CHECK(e.why == whole.why);
                CHECK(e.words == whole.words);
            }
            const ended too_long =
                run(p.request, {{2000, part(p.response, 0, cut)},
                                {2000 + limit + 200, part(p.response, cut, p.response.size())}});
            CHECK(too_long.why.code == errc::truncated_response);
        }
        std::vector<burst> dribble;
        for (std::size_t i = 0; i < p.response.size(); ++i)
            dribble.push_back({99'000 + limit * static_cast<std::uint32_t>(i), {p.response[i]}});
        CHECK(run(p.request, dribble).why.code == errc::ok);
    }
}

TEST_CASE("G7: in strict timing a gap above t1.5 rejects the frame, one up to t1.5 does not") {
    const std::uint32_t character = strict.character;
    const auto with_gap = [&](std::size_t at, std::uint32_t gap) {
        std::vector<burst> single;
        std::uint32_t time = 10'000;
        for (std::size_t i = 0; i < two_words.size(); ++i) {
            time += character + (i == at ? gap : 0);
            single.push_back({time, {two_words[i]}});
        }
        return run(read_two, single, strict).why.code;
    };
    CHECK(with_gap(0, 0) == errc::ok);
    for (std::size_t at = 1; at < two_words.size(); ++at) {
        CAPTURE(at);
        CHECK(with_gap(at, strict.t1_5) == errc::ok);
        CHECK(with_gap(at, strict.t1_5 + 1u) == errc::bad_gap);
        CHECK(with_gap(at, strict.t3_5) == errc::bad_gap);
        CHECK(with_gap(at, 50'000) == errc::bad_gap);
    }
}

TEST_CASE("G10: input longer than any frame never writes outside the buffer and costs only that frame") {
    tests::dice random{10};
    for (const std::size_t room : {std::size_t{7}, std::size_t{8}, std::size_t{9}, std::size_t{256}}) {
        for (const std::uint8_t first : std::array<std::uint8_t, 4>{0x01, 0x02, 0x00, 0x55}) {
            byte_list flood(5000);
            for (auto& b : flood) b = random.byte();
            flood[0] = first;
            if (room < 8) {
                CHECK(run(read_one, std::vector<burst>{{2000, flood}}, host, usual, room).why.code !=
                      errc::ok);
            } else {
                CHECK(run(write_one, std::vector<burst>{{2000, flood}}, host, usual, room).why.code !=
                      errc::ok);
            }
        }
    }
    CHECK(run(read_one, {{2000, byte_list(5000, 0x55)}, {40'000, one_word}}).why.code == errc::ok);
}

TEST_CASE(
    "G10: the response that is handed out never reaches beyond its buffer, whatever passed on the line") {
    byte_list memory(8);
    const response_limits brief{.response = milliseconds(10)};
    for (std::size_t n = 1; n <= 260; ++n) {
        byte_list foreign(n, 0x42);
        foreign[0] = 0x09;
        if (n > 1) foreign[1] = 0x03;
        if (n > 2) foreign[2] = 0xFF;
        exchange x{write_one, memory, host, brief};
        x.sent({0});
        x.feed(foreign, {5000});
        x.elapse({10'000}); // the time is over while the other frame still passes
        REQUIRE(x.done());
        REQUIRE(x.why().code == errc::timeout);
        REQUIRE(x.response().size() == 0); // none of it was a response
    }
}

TEST_CASE("an exception to a function whose response is four bytes long does not overrun its buffer") {
    byte_list memory(4 + 8, 0xA5);
    const byte_list request = framed({1, 0x41});
    exchange x{request, byte_buffer{memory}.first(4), host, usual};
    if (!x.done()) {
        x.sent({0});
        x.feed(tests::exception_response(1, 0x41, 1), {1000});
        x.elapse({200'000});
    }
    CHECK(x.done());
    CHECK(x.response().size() <= 4);
    for (std::size_t i = 4; i < memory.size(); ++i) CHECK(memory[i] == 0xA5);
}

TEST_CASE("a function code above 7Fh is no request: its response could not be told from an exception") {
    for (unsigned code = 0; code <= 255; ++code) {
        std::array<std::uint8_t, 16> room{};
        const byte_list request = framed({1, static_cast<std::uint8_t>(code), 0x20, 0x88, 0x00, 0x01});
        const exchange x{request, room, host, usual};
        CAPTURE(code);
        CHECK(x.done() == (code == 0 || code > 0x7F));
    }
}

TEST_CASE("G11: a foreign unit's frame neither completes nor extends the wait") {
    const std::vector<byte_list> foreign{
        tests::read_response(2, {0x0960}), tests::read_response(247, std::vector<std::uint16_t>(125, 0x0103)),
        framed({2, 6, 0x20, 0x88, 0, 0x64}), framed({2, 0x10, 0x20, 0x88, 0, 2}),
        tests::exception_response(2, 3, 2)};
    for (const byte_list& f : foreign) {
        for (const std::uint32_t at : {100u, 2000u, 50'000u, 90'000u, 99'900u}) {
            const ended e = run(read_one, std::vector<burst>{{at, f}});
            CHECK(e.why.code == errc::timeout);
            CHECK(e.foreign == 1);
            CHECK(e.words.empty());
            CHECK(e.at >= 100'000);
            CHECK(e.at <= 100'050);
        }
    }
    const ended many =
        run(read_one, std::vector<burst>{{2000, foreign[0] + foreign[2] + foreign[4] + foreign[1]}});
    CHECK(many.foreign == 4);
    CHECK(many.why.code == errc::timeout);
}

TEST_CASE("G11: our response is taken behind a foreign frame, at once or after a silence, and inside the "
          "wait only") {
    const byte_list foreign = tests::read_response(2, {0x1111, 0x2222});
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        CHECK(run(p.request, foreign + p.response).why.code == errc::ok);
        CHECK(run(p.request, foreign + foreign + p.response).why.code == errc::ok);
        CHECK(run(p.request, {{2000, foreign}, {30'000, p.response}}).why.code == errc::ok);
        CHECK(run(p.request, {{2000, foreign}, {150'000, p.response}}).why.code == errc::timeout);
        CHECK(run(p.request, byte_list{0} + foreign + byte_list{0, 0xFF} + p.response).why.code == errc::ok);
    }
}

TEST_CASE("G11: a frame like ours inside a foreign one is not taken") {
    // The words of unit 2 are our whole response.
    const byte_list ours = one_word + byte_list{0};
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i + 1 < ours.size(); i += 2)
        words.push_back(static_cast<std::uint16_t>(ours[i] << 8 | ours[i + 1]));
    const byte_list nested = tests::read_response(2, words);
    CHECK(run(read_one, nested).why.code == errc::timeout);
    CHECK(run(read_one, nested).foreign == 1);
    for (std::size_t cut = 1; cut < nested.size(); ++cut) {
        CAPTURE(cut);
        const ended e =
            run(read_one, {{2000, part(nested, 0, cut)}, {2000 + 15'000, part(nested, cut, nested.size())}});
        CHECK(e.why.code == errc::timeout);
    }
    // Nor if the foreign frame's CRC or a byte before it is wrong.
    for (std::size_t i = 1; i < nested.size(); ++i) {
        if (i >= 3 && i < 3 + one_word.size()) continue;
        byte_list bad = nested;
        bad[i] = static_cast<std::uint8_t>(bad[i] ^ 0x10u);
        CAPTURE(i);
        CHECK(run(read_one, bad).why.code == errc::timeout);
    }
}

TEST_CASE("G11: after a foreign frame with a wrong CRC, or of an unknown function, nothing is taken before a "
          "silence") {
    byte_list bad = tests::read_response(2, {0x1111, 0x2222});
    bad[4] = static_cast<std::uint8_t>(bad[4] ^ 1u);
    for (const byte_list& f : {bad, framed({2, 0x2B, 1, 2, 3, 4, 5, 6})}) {
        CHECK(run(read_one, f + one_word).why.code == errc::timeout);
        const ended e = run(read_one, {{2000, f}, {2000 + 21'000, one_word}});
        CHECK(e.why.code == errc::ok);
        CHECK(e.words == std::vector<std::uint16_t>{0x0960});
    }
}

TEST_CASE("G12: every exception number reaches the caller as it came, for every function") {
    for (const pair& p : pairs()) {
        for (unsigned number = 0; number <= 255; ++number) {
            const ended e =
                run(p.request, tests::exception_response(1, p.request[1], static_cast<std::uint8_t>(number)));
            REQUIRE(e.why == failure{errc::exception, static_cast<std::uint8_t>(number)});
            REQUIRE(e.words.empty());
        }
        byte_list bad = tests::exception_response(1, p.request[1], 2);
        for (std::size_t i = 1; i < bad.size(); ++i) {
            byte_list wrong = bad;
            wrong[i] = static_cast<std::uint8_t>(wrong[i] ^ 0x40u);
            REQUIRE(run(p.request, wrong).why.code != errc::exception);
            REQUIRE(run(p.request, wrong).why.code != errc::ok);
        }
    }
}

TEST_CASE("the response may come into the memory of the request") {
    for (const pair& p : pairs()) {
        for (const bool with_foreign : {false, true}) {
            byte_list memory = p.request;
            memory.resize(32);
            exchange x{bytes{memory}.first(p.request.size()), memory, host, usual};
            x.sent({0});
            const byte_list in_front = with_foreign ? tests::read_response(9, {1, 2, 3}) : byte_list{};
            for (const std::uint8_t b : in_front + p.response) x.feed(b, {1000});
            CHECK(x.done());
            CHECK(x.why().code == errc::ok);
            CHECK(same_bytes(x.response(), p.response));
        }
    }
}

TEST_CASE("G30: a broadcast is done after the turnaround, whatever is heard") {
    const byte_list all = framed({0, 6, 0x20, 0x0E, 0, 7});
    for (const byte_list& heard : {byte_list{}, all, framed({1, 6, 0x20, 0x0E, 0, 7}), byte_list(40, 0x55)}) {
        const ended e = run(all, std::vector<burst>{{2000, heard}});
        CHECK(e.why.code == errc::ok);
        CHECK(e.at >= 10'000);
        CHECK(e.at <= 10'050);
        CHECK(e.response.empty());
    }
}

TEST_CASE("an aborted exchange keeps its first reason") {
    std::array<std::uint8_t, 16> room{};
    exchange x{read_one, room, host, usual};
    x.abort(errc::partial_send, true);
    CHECK(x.done());
    CHECK(x.was_sent());
    CHECK(x.why().code == errc::partial_send);
    x.abort(errc::port_lost, false);
    CHECK(x.why().code == errc::partial_send);
    exchange y{read_one, room, host, usual};
    y.abort(errc::send_failed, false);
    CHECK_FALSE(y.was_sent());
}

TEST_CASE("an opaque function's response is as long as its buffer") {
    const byte_list request = framed({1, 0x41, 7});
    const byte_list response = framed({1, 0x41, 1, 2, 3});
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size()).why.code ==
          errc::ok);
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size() + 1).why.code ==
          errc::truncated_response);
    CHECK(run(request, std::vector<burst>{{2000, response}}, host, usual, response.size() - 1).why.code ==
          errc::bad_crc);
    CHECK(
        run(request, std::vector<burst>{{2000, tests::exception_response(1, 0x41, 9)}}, host, usual, 8).why ==
        failure{errc::exception, 9});
}

namespace {

struct plain_store {
    std::array<std::uint16_t, 64> words{};
    static constexpr bool covers(std::uint16_t address, std::size_t count) { return address + count <= 64; }
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        if (!covers(address, to.size())) return 2;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[address + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (!covers(address, from.size())) return 2;
        for (std::size_t i = 0; i < from.size(); ++i) words[address + i] = from[i];
        return 0;
    }
};

// Random bytes that often look like the right thing.
byte_list rubbish(tests::dice& random, std::uint8_t unit) {
    byte_list b(random.below(random.below(8) == 0 ? 300 : 24));
    for (auto& x : b) x = random.byte();
    const std::uint8_t codes[] = {3, 4, 6, 16, 0x83, 0x90, 0x2B, 0};
    if (!b.empty() && random.below(4) != 0) b[0] = random.below(8) == 0 ? std::uint8_t{0} : unit;
    if (b.size() > 1 && random.below(4) != 0) b[1] = codes[random.below(8)];
    if (b.size() > 2 && random.below(2) != 0) b[2] = static_cast<std::uint8_t>(b.size() - 5);
    if (b.size() > 6 && random.below(2) != 0) b[6] = static_cast<std::uint8_t>(b.size() - 9);
    if (b.size() > 3 && random.below(3) != 0) {
        b.resize(b.size() - 2);
        b = framed(std::move(b));
    }
    return b;
}

} // namespace

TEST_CASE("G32: random bytes do no harm to an exchange, and never pass for a response that they are not") {
    tests::dice random{32};
    unsigned good = 0;
    for (int i = 0; i < 200'000; ++i) {
        const pair& p = pairs()[random.below(4)];
        std::array<std::uint8_t, 9> room{};
        exchange x{p.request, byte_buffer{room}.first(p.response.size()), random.below(2) ? host : strict,
                   usual};
        x.sent({0});
        byte_list heard;
        std::uint32_t time = 0;
        for (int n = 0; n < 6 && !x.done(); ++n) {
            const byte_list b = random.below(16) == 0 ? p.response : rubbish(random, 1);
            time += random.below(3) == 0 ? random.below(40'000) : random.below(1000);
            heard = heard + b;
            x.feed(b, {time});
            x.elapse({time});
            REQUIRE(x.response().size() <= p.response.size());
        }
        x.elapse({time + 30'000});
        x.elapse({time + 200'000});
        x.elapse({time + 400'000});
        REQUIRE(x.done());
        if (x.why().code != errc::ok) continue;
        ++good;
        REQUIRE(tests::crc_of(x.response()) == 0);
        REQUIRE(x.response()[0] == 1);
        REQUIRE(x.response()[1] == p.request[1]);
        bool was_heard = false;
        for (std::size_t at = 0; at + x.response().size() <= heard.size() && !was_heard; ++at)
            was_heard = same_bytes(bytes{heard}.subspan(at, x.response().size()), x.response());
        REQUIRE(was_heard);
        if (p.request[1] != 0x03) REQUIRE(same_bytes(x.response(), p.response));
    }
    CHECK(good > 1000);
}

TEST_CASE("G7: what comes in one piece, in two or byte by byte at the same time ends the same") {
    tests::dice random{7};
    unsigned good = 0;
    for (int i = 0; i < 100'000; ++i) {
        const pair& p = pairs()[random.below(4)];
        byte_list heard;
        for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
            byte_list b = random.below(2) == 0 ? p.response : rubbish(random, 1);
            if (random.below(3) == 0 && !b.empty()) {
                const std::size_t at = random.below(static_cast<std::uint32_t>(b.size()));
                b[at] = static_cast<std::uint8_t>(b[at] ^ (1u << random.below(8)));
            }
            heard = heard + b;
        }
        const std::size_t cut = random.below(static_cast<std::uint32_t>(heard.size() + 1));
        std::array<std::array<std::uint8_t, 9>, 3> room{};
        std::array<exchange, 3> x;
        std::array<std::size_t, 3> taken{};
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = exchange{p.request, byte_buffer{room[k]}.first(p.response.size()), host, usual};
            x[k].sent({0});
        }
        taken[0] = x[0].feed(heard, {2000});
        taken[1] = x[1].feed(bytes{heard}.first(cut), {2000});
        if (taken[1] == cut) taken[1] += x[1].feed(bytes{heard}.subspan(cut), {2000});
        for (const std::uint8_t b : heard) taken[2] += x[2].feed(b, {2000});
        for (std::size_t k = 0; k < 3; ++k) {
            for (const std::uint32_t t : {2000u, 50'000u, 200'000u}) x[k].elapse({t});
            REQUIRE(x[k].done());
            REQUIRE(x[k].why() == x[0].why());
            REQUIRE(taken[k] == taken[0]);
            REQUIRE(x[k].other_unit_frames() == x[0].other_unit_frames());
            REQUIRE(same_bytes(x[k].response(), x[0].response()));
            REQUIRE(x[k].words().size() == x[0].words().size());
        }
        good += x[0].why().code == errc::ok;
    }
    CHECK(good > 1000);
}

TEST_CASE("G32: random bytes do no harm to a server, and all it says are frames of its own") {
    tests::dice random{33};
    plain_store store;
    unsigned answers = 0;
    for (const timing_mode mode : {timing_mode::host, timing_mode::strict}) {
        server s{7, store, timing_at(9600, mode)};
        std::uint32_t time = 0;
        for (int i = 0; i < 100'000; ++i) {
            time += random.below(3) == 0 ? random.below(60'000) : random.below(1500);
            if (random.below(4) == 0) s.elapse({time});
            byte_list b = rubbish(random, 7);
            if (b.size() == 8 && random.below(2) == 0) {
                b = framed({7, static_cast<std::uint8_t>(random.below(2) ? 3 : 6), 0, random.byte(), 0, 3});
            }
            s.feed(b, {time});
            time += random.below(30'000);
            s.elapse({time});
            const bytes said = s.response({time});
            if (said.empty()) continue;
            ++answers;
            REQUIRE(said.size() <= 256);
            REQUIRE(said[0] == 7);
            REQUIRE(tests::crc_of(said) == 0);
            if (random.below(8) != 0) s.sent({time + 1000});
        }
    }
    CHECK(answers > 1000);
}

TEST_CASE("G32: random bytes do no harm when taken apart") {
    tests::dice random{34};
    unsigned requests = 0;
    unsigned responses = 0;
    for (int i = 0; i < 200'000; ++i) {
        const byte_list b = rubbish(random, 1);
        const byte_list exact(b.begin(), b.end());
        if (const auto r = open_frame(exact)) {
            REQUIRE(r->pdu.data() + r->pdu.size() + 2 == exact.data() + exact.size());
            if (const auto q = parse_request(r->pdu)) {
                ++requests;
                REQUIRE(q->quantity >= 1);
                REQUIRE(q->address + q->quantity <= 0x1'0000);
                REQUIRE(q->values().size() == (is_write(q->code) ? q->quantity : 0));
                if (q->values().size() != 0) (void)q->values()[q->values().size() - 1];
            }
            if (const auto a = parse_response(r->pdu)) {
                ++responses;
                if (is_read(a->code) && !a->is_exception) REQUIRE(a->values().size() == a->quantity);
            }
        }
    }
    CHECK(requests > 100);
    CHECK(responses > 100);
}

TEST_CASE("a response that came whole was received, as one that came byte by byte") {
    const auto request = read_frame(1, 0x20AB, 2);
    const auto response = hex("01 03 04 00 64 FF 9C FA 75");
    for (const std::size_t piece : {response.size, std::size_t{1}}) {
        CAPTURE(piece);
        std::array<std::uint8_t, 9> buffer{};
        exchange x{request, buffer, host, usual};
        CHECK_FALSE(x.has_heard());
        x.sent({0});
        CHECK_FALSE(x.has_heard());
        for (std::size_t at = 0; at < response.size; at += piece)
            x.feed(bytes{response}.subspan(at).first(piece), {1000});
        CHECK(x.why() == failure{});
        CHECK(x.has_heard());
    }
}
