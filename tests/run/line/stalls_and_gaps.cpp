// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program that stalls once while its response is awaited: between reading the clock and receiving, between
// two receives, or while it sleeps. The clock is then late for the bytes that came meanwhile, which is no gap
// between them. Each test plays a stall before every single call of the port.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/blocking_line_rig.hpp>
#include <tests/support/line_rig.hpp>
#include <tests/support/neighbours.hpp>
#include <tests/support/stalling_port.hpp>

namespace stalls_and_gaps_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::stalling_port;
using tests::waiting_scripted_port;
using tests::operator+;
using tests::blocking::one_word;
using tests::blocking::read_one;

namespace {

constexpr auto strict = modbus::timing_at(115200, modbus::timing_mode::strict);

/// A `line` on such a port.
template <class Base, modbus::rtu_timing Timing> struct whole {
    static constexpr modbus::rtu_timing timing = Timing;
    tests::whole_line::rig<stalling_port<Base>> of{Timing};
    stalling_port<Base>& port = of.port;
    response_limits& limits = of.limits;

    whole() { of.settle(); }
    errc ask(const byte_list& request) { return of.run(request).why.error(); }
};
/// A `blocking_line` on one.
template <class Base, modbus::rtu_timing Timing> struct small {
    static constexpr modbus::rtu_timing timing = Timing;
    tests::blocking::rig<tests::blocking::setup<stalling_port<Base>, Timing>> of;
    stalling_port<Base>& port = of.port;
    response_limits& limits = of.limits;

    errc ask(const byte_list& request) { return of.ask(request); }
};
#define ALL_LINES                                                                                            \
    whole<scripted_port, modbus::timing_at(115200)>,                                                         \
        whole<waiting_scripted_port, modbus::timing_at(115200)>, whole<scripted_port, strict>,               \
        small<scripted_port, modbus::timing_at(115200)>,                                                     \
        small<waiting_scripted_port, modbus::timing_at(115200)>, small<scripted_port, strict>

/// Asks once for each call before which the program may stall: `check` gets how it ended. Returns how many
/// stalls were played.
template <class Line, class Device, class Check>
unsigned with_every_stall(const byte_list& request, std::uint32_t stall_us, const Device& device,
                          const Check& check) {
    unsigned played = 0;
    for (std::uint64_t call = 1;; ++call) {
        Line r;
        r.port.call_us = 50;                  // two calls for each byte
        r.limits.response = milliseconds(15); // a little after the last byte
        r.port.device = device;
        r.port.stalls_at = call;
        r.port.stall_us = stall_us;
        CAPTURE(call);
        CAPTURE(stall_us);
        const errc why = r.ask(request);
        if (r.port.stalls == 0 || r.port.is_over) return played;
        played += r.port.stalls;
        check(why);
    }
}

constexpr std::uint32_t stalls_us[] = {1'500, 3'000, 30'000, 300'000};

} // namespace

TEST_CASE_TEMPLATE(
    "G2, G6, G41: a stall inside a frame of another node is no gap: what it contains is no response", L,
    ALL_LINES) {
    // In the second frame the CRC also fits before the response.
    for (const byte_list& f :
         {framed(byte_list{9, 0x65, 0x3C} + one_word), framed(framed({9, 0x65, 1, 2, 3}) + one_word),
          framed({9, 0x65, 1, 2, 3}) + one_word}) {
        for (const std::uint32_t stall_us : stalls_us) {
            const unsigned played = with_every_stall<L>(
                read_one, stall_us, [&](scripted_port& p, const sent_frame&) { p.say(2'000, f); },
                [](errc why) { REQUIRE(why == errc::timeout); });
            CHECK(played > 15);
        }
    }
}

TEST_CASE_TEMPLATE(
    "G2, G6: a frame of another node that begins while the request leaves is no response, nor is what "
    "it contains, also after a stall",
    L, ALL_LINES) {
    const byte_list head{9, 0x65, 0x3C, 0xFF};
    unsigned begun_before = 0; // frames whose first byte came before the request had left
    for (const byte_list& f : {framed(head + one_word), head + head + one_word}) {
        for (const std::size_t taken_at_once : {std::size_t{1}, std::size_t{1000}}) {
            for (const std::uint32_t stall_us : {0u, 300u, 1'500u, 30'000u}) {
                for (std::uint32_t shift_us = 0; shift_us < 12 * 96; shift_us += 48) {
                    for (std::uint64_t call = 1; call < (stall_us == 0 ? 2u : 12u); ++call) {
                        L r;
                        r.port.call_us = 20;
                        r.port.takes_at_most = taken_at_once;
                        r.limits.response = milliseconds(15);
                        r.port.device = [&](scripted_port& p, const sent_frame& sent) {
                            p.say_at(sent.begin + shift_us, f);
                            begun_before += sent.begin + shift_us + 96 < sent.end;
                            r.port.is_armed = true;
                        };
                        r.port.stalls_at = call;
                        r.port.stall_us = stall_us;
                        CAPTURE(call);
                        CAPTURE(shift_us);
                        CAPTURE(stall_us);
                        CAPTURE(taken_at_once);
                        REQUIRE(r.ask(read_one) == errc::timeout);
                    }
                }
            }
        }
    }
    CHECK(begun_before > 1'500);
}

TEST_CASE_TEMPLATE("an echo that no line handles, and a driver that is switched, leave the response as it is",
                   L, ALL_LINES) {
    for (const bool has_echo : {false, true}) {
        for (const std::uint8_t glitch : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
            L r;
            r.port.call_us = 20;
            r.port.echoes = has_echo;
            r.limits.response = milliseconds(15);
            r.port.device = [&](scripted_port& p, const sent_frame& sent) {
                p.arrive(sent.begin + 10, glitch);
                p.arrive(sent.begin + 250, glitch);
                p.say(2'000, one_word);
            };
            CAPTURE(has_echo);
            REQUIRE(r.ask(read_one) == errc::ok);
        }
    }
}

TEST_CASE_TEMPLATE("G7: a stall inside a response is no gap in it", L, ALL_LINES) {
    for (const std::uint32_t stall_us : stalls_us) {
        const unsigned played = with_every_stall<L>(
            read_one, stall_us, [](scripted_port& p, const sent_frame&) { p.say(2'000, one_word); },
            [](errc why) { REQUIRE(why == errc::ok); });
        CHECK(played > 15);
    }
}

TEST_CASE_TEMPLATE("G3: a stall inside an echo is no gap after a response that would equal its beginning", L,
                   ALL_LINES) {
    byte_list request; // a read whose first seven bytes are a response to it
    for (unsigned number = 0; number < 246 * 256u && request.empty(); ++number) {
        const byte_list q = framed({tests::low_byte(number / 256 + 1), 3, 2, tests::low_byte(number), 0, 1});
        if (tests::crc_of(bytes{q}.first(7)) == 0) request = q;
    }
    REQUIRE(request.size() == 8);
    for (const std::uint32_t stall_us : stalls_us) {
        const unsigned played = with_every_stall<L>(
            request, stall_us, [&](scripted_port& p, const sent_frame&) { p.say(2'000, request); },
            [](errc why) { REQUIRE(why == errc::own_echo); });
        CHECK(played > 15);
    }
}

TEST_CASE_TEMPLATE(
    "G41: after a stall inside a frame of another node the line accepts a response after a gap that "
    "it saw",
    L, ALL_LINES) {
    const byte_list f = framed(framed({9, 0x65, 1, 2, 3}) + one_word);
    const std::uint32_t end = 2'000 + L::timing.wire_time(f.size()).us;
    for (const std::uint32_t stall_us : {1'500u, 3'000u}) {
        const unsigned played = with_every_stall<L>(
            read_one, stall_us,
            [&](scripted_port& p, const sent_frame&) {
                p.say(2'000, f);
                p.say(end + 2 * stall_us + L::timing.t3_5 + 200, one_word);
            },
            [](errc why) { REQUIRE(why == errc::ok); });
        CHECK(played > 15);
    }
}

TEST_CASE("G1: a blocking line that sleeps counts the quarantine from the end of its call, also after a byte "
          "of another node just before that") {
    using setup = tests::blocking::sleeps;
    for (std::uint32_t early = 100; early < 25'000; early += 700) {
        CAPTURE(early);
        tests::blocking::rig<setup> r;
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            if (f.data[3] == 0xA1) p.say(r.limits.response.us - early, {0x66, 0x66});
        };
        REQUIRE(r.ask(read_one) == errc::timeout);
        const std::uint64_t end = r.port.time;
        CHECK(end - r.port.frames.back().end <= r.limits.response.us + 100);
        CHECK(r.ask(tests::blocking::read_other) == errc::timeout);
        CHECK(r.port.frames.back().begin - end >= setup::after_trouble - 10);
    }
}

} // namespace stalls_and_gaps_tests
