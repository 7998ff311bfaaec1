// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server in a program that stalls once: between reading the clock and receiving, or between two receives. The
// clock is then late for the bytes that came meanwhile, which is no gap between them. Each test plays a stall
// before every single call of the port.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <servobus/modbus/server.hpp>

#include <tests/support/served_words.hpp>
#include <tests/support/stalling_port.hpp>

namespace server_stalls_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::operator+;
using namespace tests::served;

namespace {

const byte_list write_5 = framed({1, 0x06, 0, 2, 0, 5});
const byte_list write_9 = framed({1, 0x06, 0, 2, 0, 9});
constexpr std::uint32_t stalls_us[] = {1'500, 3'000, 30'000, 300'000};
constexpr std::uint64_t begin_us = 5'000;

/// A program that serves node 1 until the true time `end_us`.
struct program {
    tests::stalling_port<> port;
    one_word store;
    modbus::server<one_word> server;

    explicit program(modbus::timing_mode mode) : server{1, store, modbus::timing_at(115200, mode)} {
        port.call_us = 30;
        port.is_armed = true;
    }
    void run(std::uint64_t end_us) {
        std::array<std::uint8_t, 64> chunk{};
        while (port.time < end_us) {
            const instant before = port.now();
            const transfer came = port.receive(chunk);
            if (*came == 0)
                server.elapse(before);
            else
                server.feed_late(bytes{chunk}.first(*came), port.now());
            const bytes response = server.response(port.now());
            if (response.empty()) continue;
            (void)port.send(response);
            while (!port.sent()) {}
            server.sent(port.now());
        }
    }
};

/// Plays `script` once for each call before which the program may stall; `check` judges the program. Returns how
/// many stalls were played.
template <class Script, class Check>
unsigned with_every_stall(modbus::timing_mode mode, std::uint32_t stall_us, const Script& script,
                          const Check& check) {
    for (unsigned call = 1;; ++call) {
        CAPTURE(static_cast<int>(mode));
        CAPTURE(call);
        CAPTURE(stall_us);
        program p{mode};
        p.port.stalls_at = call;
        p.port.stall_us = stall_us;
        script(p.port);
        p.run(p.port.last_arrival() + stall_us + 50'000);
        REQUIRE(p.port.stalls == 1);
        if (p.port.is_over) return call - 1;
        check(p);
    }
}

} // namespace

TEST_CASE(
    "G6, G13, G41: a stall inside a frame of another node is no gap: nothing that it contains is executed") {
    for (const auto mode : both_modes) {
        for (const byte_list& f :
             {framed(byte_list{9, 0x65, 0x3C} + write_5), framed(framed({9, 0x65, 1, 2, 3}) + write_5),
              framed({9, 0x65, 1, 2, 3}) + write_5,
              framed(byte_list{9, 0x03, 10, 7} + write_5 + byte_list{7}),
              framed(byte_list{9, 0x10, 0, 0, 0, 4, 8} + write_5)}) {
            for (const std::uint32_t stall_us : stalls_us) {
                const unsigned played = with_every_stall(
                    mode, stall_us, [&](tests::scripted_port& p) { p.say_at(begin_us, f); },
                    [](const program& p) {
                        REQUIRE(p.store.accesses == 0);
                        REQUIRE(p.port.frames.empty());
                    });
                CHECK(played > 20);
            }
        }
    }
}

TEST_CASE("G13, G14: a request in which the program stalls is executed once, and gets its response") {
    for (const auto mode : both_modes) {
        for (const std::uint32_t stall_us : stalls_us) {
            const unsigned played = with_every_stall(
                mode, stall_us, [&](tests::scripted_port& p) { p.say_at(begin_us, write_5); },
                [](const program& p) {
                    REQUIRE(p.store.accesses == 1);
                    REQUIRE(p.port.frames.size() == 1);
                    REQUIRE(p.port.frames[0].data == write_5);
                });
            CHECK(played > 20);
        }
    }
}

TEST_CASE("G13, G14: after a stall inside a frame of another node a request is executed after a gap that was "
          "seen") {
    const byte_list f = framed(framed({9, 0x65, 1, 2, 3}) + write_5);
    for (const auto mode : both_modes) {
        for (const std::uint32_t stall_us : stalls_us) {
            const unsigned played = with_every_stall(
                mode, stall_us,
                [&](tests::scripted_port& p) {
                    p.say_at(begin_us, f);
                    p.say_at(p.last_arrival() + stall_us + 25'000, write_9);
                },
                [](const program& p) {
                    // The stall may also cover the gap: then nothing is executed, and nothing else either.
                    const bool is_seen = p.store.accesses == 1;
                    REQUIRE(p.store.word == (is_seen ? 9 : 0));
                    REQUIRE(is_seen);
                });
            CHECK(played > 20);
        }
    }
}

TEST_CASE("G13, G14: a call with no bytes is no byte: the line was quiet before it, and is so after it") {
    for (const auto mode : both_modes) {
        CAPTURE(static_cast<int>(mode));
        bench b{mode};
        b.server.feed_late({}, b.now); // before the first byte
        b.server.feed({}, b.now);
        b.receive(write_5);
        CHECK(b.response() == write_5);
        b.receive(byte_list(write_9.begin(), write_9.end() - 1)); // cut: a gap ends it
        for (std::uint32_t us = 0; us < b.timing.visible_gap().us + 1'000; us += 100) {
            b.quiet(100);
            b.server.feed_late({}, b.now);
            b.server.feed({}, b.now);
        }
        b.receive(write_5);
        CHECK(b.response() == write_5);
        CHECK(b.store.accesses == 2);
    }
}

} // namespace server_stalls_tests
