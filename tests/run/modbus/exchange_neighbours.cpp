// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An exchange on a line with other nodes that use functions of all kinds: the response is accepted after
// their frames, and no part of their frames is ever a response.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include <servobus/modbus/exchange.hpp>

#include <tests/support/exchange_runs.hpp>
#include <tests/support/neighbours.hpp>

namespace exchange_neighbours_tests {

using namespace servobus;
using namespace servobus::modbus;
using namespace tests::exchange_runs;
using tests::byte_list;
using tests::framed;
using tests::operator+;
namespace neighbours = tests::neighbours;

namespace {

constexpr std::uint32_t t3_5 = host.t3_5;

// Fed without any call of `elapse` between the bursts, unless the test asks for it.
status fed(const byte_list& request, const std::vector<burst>& bursts, bool is_polled) {
    std::array<std::uint8_t, 32> room{};
    exchange x{request, room, host, usual};
    const instant start{0xFFFF'F000u};
    x.sent(start);
    std::uint32_t time = 0;
    for (const burst& b : bursts) {
        for (; is_polled && time < b.at && !x.done(); time += 50) x.elapse(start + microseconds(time));
        time = b.at;
        x.feed(b.data, start + microseconds(time));
    }
    for (; !x.done() && time < 500'000; time += 1000) x.elapse(start + microseconds(time));
    REQUIRE(x.done());
    return x.status();
}

} // namespace

TEST_CASE("G11, G41: the response is accepted t3.5 after a frame of another node, of whatever function") {
    for (const std::uint8_t code : neighbours::functions) {
        tests::dice random{code};
        const neighbours::pair other = neighbours::pair_of(9, code, {1, 2, 3, 4}, random);
        for (const byte_list& f : {other.response, other.request}) {
            for (const pair& p : pairs()) {
                for (const std::uint32_t gap : {t3_5, 8'000u, 19'000u, 25'000u}) {
                    CAPTURE(static_cast<int>(code));
                    CAPTURE(p.name);
                    CAPTURE(gap);
                    const auto last = gap + host.wire_time(p.response.size()).us;
                    CHECK(fed(p.request, {{2000, f}, {2000 + last, p.response}}, false) == errc::ok);
                    CHECK(fed(p.request, {{2000, f}, {2000 + last, p.response}}, true) == errc::ok);
                    std::vector<burst> single;
                    std::uint32_t at = 2000;
                    for (const std::uint8_t byte : f) single.push_back({at += host.character, {byte}});
                    at += gap;
                    for (const std::uint8_t byte : p.response)
                        single.push_back({at += host.character, {byte}});
                    CHECK(fed(p.request, single, false) == errc::ok);
                }
            }
        }
    }
}

TEST_CASE("G41: the response follows without a gap on a response of another node whose function gives its "
          "length, and "
          "on no other") {
    for (const std::uint8_t code : neighbours::functions) {
        CAPTURE(static_cast<int>(code));
        tests::dice random{code};
        const byte_list other = neighbours::pair_of(9, code, {1, 2, 3, 4}, random).response;
        const bool is_ok = neighbours::has_length(code);
        CHECK((run(read_one, other + one_word).why.error() == errc::ok) == is_ok);
        CHECK((fed(read_one, {{2000, other}, {2000 + t3_5, one_word}}, false) == errc::ok) == is_ok);
    }
}

TEST_CASE("G11: a gap that ends a frame in the line's timing also ends one of another node whose CRC fits") {
    for (const byte_list& f : {framed({9, 0x65, 1, 2, 3}), framed({9, 0x65, 1, 2, 3}) + byte_list{7}}) {
        // In strict timing t1.5, in host timing `inter_byte`, which may be as short as t3.5.
        for (const rtu_timing& timing : {strict, timing_at(115200, timing_mode::host, milliseconds(0))}) {
            const bool is_strict = timing.mode == timing_mode::strict;
            const std::uint32_t gap = is_strict ? timing.t1_5 + timing.wire_time(7).us : timing.t3_5;
            for (const std::uint32_t more : {0u, 1u}) {
                std::array<std::uint8_t, 7> room{};
                exchange x{read_one, room, timing, usual};
                x.sent({0});
                x.feed(f, {20'000});
                x.feed(one_word, {20'000 + gap + more});
                x.elapse({200'000});
                CHECK((x.status() == errc::ok) == (more == 1));
            }
        }
    }
}

TEST_CASE("G41: a pause that `elapse` has seen counts, also if the whole response then comes in no time") {
    const std::uint32_t seen = t3_5 + host.character;
    for (const std::uint32_t looked : {seen - 1, seen}) { // as on a pseudo-terminal
        std::array<std::uint8_t, 7> room{};
        exchange x{read_one, room, host, usual};
        x.sent({0});
        x.feed(framed({9, 0x65, 1, 2, 3}), {2000});
        x.elapse({2000 + looked});
        x.feed(one_word, {2000 + looked + 10});
        x.elapse({200'000});
        CHECK((x.status() == errc::ok) == (looked == seen));
    }
}

TEST_CASE("G6, G41: a response inside a frame of function 65h is not accepted, however the frame is cut") {
    for (const pair& p : pairs()) {
        for (std::size_t before = 0; before < 4; ++before) {
            for (const std::size_t zeros : {0u, 1u, 5u}) {
                const byte_list all = framed(byte_list{9, 0x65} + byte_list(before, 0x3C) + p.response) +
                                      byte_list(zeros, 0x00);
                for (std::size_t cut = 1; cut + zeros < all.size(); ++cut) {
                    for (const std::uint32_t pause : {0u, 1'000u, 2'500u, 19'000u}) {
                        const std::vector<burst> cut_frame{{2000, part(all, 0, cut)},
                                                           {2000 + pause, part(all, cut, all.size())}};
                        REQUIRE(fed(p.request, cut_frame, true) == errc::timeout);
                        std::vector<burst> followed = cut_frame;
                        followed.push_back({2000 + pause + t3_5 + 1000, p.response});
                        REQUIRE(fed(p.request, followed, true) == errc::ok);
                        REQUIRE(fed(p.request, followed, false) == errc::ok);
                    }
                }
            }
        }
    }
}

TEST_CASE("G6, G41: a frame of another node whose CRC fits in its middle goes on if no pause follows there") {
    const byte_list begun = framed({9, 0x65, 1, 2, 3});
    const byte_list whole = framed(begun + one_word);
    const byte_list rest(whole.begin() + static_cast<std::ptrdiff_t>(begun.size()), whole.end());
    for (const std::uint32_t pause : {0u, 500u, t3_5 - 1}) {
        for (const bool is_polled : {false, true}) {
            CHECK(fed(read_one, {{2000, begun}, {2000 + pause, rest}}, is_polled) == errc::timeout);
            CHECK(fed(read_one, {{2000, begun}, {2000 + pause, rest}, {8000, one_word}}, is_polled) ==
                  errc::ok);
        }
    }
    // Bytes that came together began earlier: if they filled the time since the byte before, there was no
    // pause.
    const std::uint32_t filled = host.wire_time(rest.size()).us;
    CHECK(fed(read_one, {{2000, begun}, {2000 + filled + 1000, rest}}, false) == errc::timeout);
}

TEST_CASE("G11, G41: among frames of other nodes of all functions the response is accepted, and nothing in "
          "them is") {
    tests::dice random{41};
    std::map<unsigned, unsigned> played;
    unsigned embedded = 0;
    unsigned unanswered = 0;
    for (int i = 0; i < 20'000; ++i) {
        const pair& p = pairs()[random.below(4)];
        const bool has_response = random.below(4) != 0;
        unanswered += !has_response;
        std::vector<burst> bursts;
        std::uint32_t at = 500;
        const auto say = [&](const byte_list& all, bool may_pause) {
            for (std::size_t from = 0; from < all.size();) {
                const std::size_t size = std::min<std::size_t>(1 + random.below(40), all.size() - from);
                if (from != 0) at += random.below(4) == 0 ? random.below(may_pause ? 12'000 : 1'600) : 0;
                at += host.wire_time(size).us;
                bursts.push_back({at, part(all, from, from + size)});
                from += size;
            }
        };
        for (unsigned n = 1 + random.below(2); n != 0; --n) {
            const std::uint8_t code = neighbours::functions[random.below(neighbours::functions.size())];
            ++played[code];
            byte_list payload(random.below(10), random.byte());
            if (random.below(2) == 0) ++embedded, payload = payload + p.response + payload;
            const neighbours::pair other = neighbours::pair_of(9, code, payload, random);
            say(other.response, neighbours::has_length(code));
            at += random.below(2) == 0 ? t3_5 : t3_5 + random.below(7'000);
        }
        if (has_response) say(p.response, true);
        const status ended = fed(p.request, bursts, random.below(2) == 0);
        REQUIRE(ended == (has_response ? errc::ok : errc::timeout));
    }
    for (const std::uint8_t code : neighbours::functions) REQUIRE(played[code] > 500);
    REQUIRE(embedded > 5'000);
    REQUIRE(unanswered > 2'000);
}

} // namespace exchange_neighbours_tests
