// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random bytes, which often look like a frame, for an exchange, for a server and for the functions that parse
// a frame: no harm is done, and nothing is accepted as a response that is none.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include <servobus/modbus/exchange.hpp>
#include <servobus/modbus/server.hpp>

#include <tests/support/exchange_runs.hpp>

namespace exchange_random_tests {

using namespace servobus;
using namespace servobus::modbus;
using namespace tests::exchange_runs;
using tests::byte_list;
using tests::framed;
using tests::operator+;

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

// Random bytes that often look like a frame.
byte_list random_bytes(tests::dice& random, std::uint8_t node_address) {
    byte_list b(random.below(random.below(8) == 0 ? 300 : 24));
    for (auto& x : b) x = random.byte();
    const std::uint8_t codes[] = {3, 4, 6, 16, 0x83, 0x90, 0x2B, 0};
    if (!b.empty() && random.below(4) != 0) b[0] = random.below(8) == 0 ? std::uint8_t{0} : node_address;
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

TEST_CASE(
    "G32: random bytes do no harm to an exchange, and are never accepted as a response that they are not") {
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
            const byte_list b = random.below(16) == 0 ? p.response : random_bytes(random, 1);
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
        if (x.status().error() != errc::ok) continue;
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

TEST_CASE("G7: bytes that arrive at the same time end the same in one piece, in two or byte by byte") {
    tests::dice random{7};
    unsigned good = 0;
    for (int i = 0; i < 100'000; ++i) {
        const pair& p = pairs()[random.below(4)];
        byte_list heard;
        for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
            byte_list b = random.below(2) == 0 ? p.response : random_bytes(random, 1);
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
            REQUIRE(x[k].status() == x[0].status());
            REQUIRE(taken[k] == taken[0]);
            REQUIRE(same_bytes(x[k].response(), x[0].response()));
            REQUIRE(x[k].words().size() == x[0].words().size());
        }
        good += x[0].status().error() == errc::ok;
    }
    CHECK(good > 1000);
}

TEST_CASE("G32: random bytes do no harm to a server, and it sends only frames of its own") {
    tests::dice random{33};
    plain_store store;
    unsigned answers = 0;
    for (const timing_mode mode : {timing_mode::host, timing_mode::strict}) {
        server s{7, store, timing_at(9600, mode)};
        std::uint32_t time = 0;
        for (int i = 0; i < 100'000; ++i) {
            time += random.below(3) == 0 ? random.below(60'000) : random.below(1500);
            if (random.below(4) == 0) s.elapse({time});
            byte_list b = random_bytes(random, 7);
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

TEST_CASE("G32: random bytes do no harm when they are parsed") {
    tests::dice random{34};
    unsigned requests = 0;
    unsigned responses = 0;
    for (int i = 0; i < 200'000; ++i) {
        const byte_list b = random_bytes(random, 1);
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

} // namespace exchange_random_tests
