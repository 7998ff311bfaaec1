// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Bytes that are there together, as in the ring of an interrupt or after a pause of the program, from a port that
// gives one a call. A line may take them without a look at the clock between them, but nothing is lost by it: not
// the quarantine after a port that fails among them, not the byte after the response, and in strict timing no gap.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>
#include <tests/support/line_rig.hpp>
#include <tests/support/stalling_port.hpp>

namespace bytes_at_once_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::waiting_scripted_port;

namespace {

constexpr auto host = modbus::timing_at(115200);
constexpr auto strict = modbus::timing_at(115200, modbus::timing_mode::strict);
const byte_list read_eight = framed({1, 3, 0x20, 0xA5, 0, 8});
const byte_list eight_words = tests::blocking::good_response(read_eight);

/// A port that fails once, as soon as all bytes were taken: a character that is garbled as a driver is switched. Counts
/// the looks at the clock.
template <class Base> struct counting_port : Base {
    bool garbles_next = false;
    mutable unsigned looks = 0;

    transfer receive(byte_buffer in) {
        if (garbles_next && Base::not_yet_received() == 0) {
            garbles_next = false;
            return errc::receive_failed;
        }
        return Base::receive(in);
    }
    instant now() {
        ++looks;
        return Base::now();
    }
};

template <class Port, modbus::rtu_timing Timing> struct whole {
    tests::whole_line::rig<Port> of{Timing};
    Port& port = of.port;

    whole() {
        of.settle();
        port.gives_at_most = 1;
    }
    errc ask(const byte_list& request) { return of.run(request).why.error(); }
};
template <class Port, modbus::rtu_timing Timing> struct small {
    tests::blocking::rig<tests::blocking::setup<Port, Timing>> of;
    Port& port = of.port;

    small() { port.gives_at_most = 1; }
    errc ask(const byte_list& request) { return of.ask(request); }
};
#define EACH_LINE(PORT)                                                                                      \
    whole<PORT<scripted_port>, host>, whole<PORT<waiting_scripted_port>, host>,                              \
        whole<PORT<scripted_port>, strict>, small<PORT<scripted_port>, host>,                                \
        small<PORT<waiting_scripted_port>, host>, small<PORT<scripted_port>, strict>

/// All bytes of the response are there 2 ms after the request.
void say_at_once(scripted_port& p, const sent_frame& f, const byte_list& response) {
    for (const std::uint8_t b : response) p.arrive(f.end + 2'000, b);
}

} // namespace

TEST_CASE_TEMPLATE("G1: after a port that fails among bytes that are there, the quarantine counts from then",
                   L, EACH_LINE(counting_port)) {
    for (const std::uint32_t receive_us : {0u, 50u, 300u}) {
        unsigned played = 0;
        for (std::uint64_t call = 1; call < 400; ++call) {
            CAPTURE(receive_us);
            CAPTURE(call);
            L r;
            r.port.call_us = 20;
            r.port.receive_us = receive_us;
            r.port.device = [&](scripted_port& p, const sent_frame& f) { say_at_once(p, f, eight_words); };
            r.port.fails_at_call = r.port.calls + call;
            if (r.ask(read_eight) != errc::receive_failed) continue;
            const std::size_t left = r.port.not_yet_received();
            if (left == 0 || left == eight_words.size()) continue;
            ++played;
            const std::uint64_t failed = r.port.time;
            std::uint8_t byte[1];
            r.port.receive_us = 0;
            while (r.port.not_yet_received() != 0) (void)r.port.receive(byte);
            r.port.device = tests::whole_line::answering(500);
            (void)r.ask(tests::blocking::read_one);
            CHECK(r.port.frames.back().begin + 40 >= failed + 100'000);
        }
        CHECK(played > 10);
    }
}

TEST_CASE_TEMPLATE("a character that is garbled after a response does not spoil it", L,
                   EACH_LINE(counting_port)) {
    L r;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        say_at_once(p, f, eight_words);
        r.port.garbles_next = true;
    };
    CHECK(r.ask(read_eight) == errc::ok);
    CHECK(r.port.garbles_next); // it was not asked for
}

TEST_CASE_TEMPLATE("a blocking line in host timing takes what is there between two looks at the clock", L,
                   small<counting_port<scripted_port>, host>,
                   small<counting_port<waiting_scripted_port>, host>) {
    unsigned looks[2];
    for (const bool is_long : {false, true}) {
        L r;
        const byte_list request = is_long ? read_eight : tests::blocking::read_one;
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            say_at_once(p, f, tests::blocking::good_response(request));
        };
        r.port.looks = 0;
        CHECK(r.ask(request) == errc::ok);
        looks[is_long ? 1 : 0] = r.port.looks;
    }
    CHECK(looks[1] <= looks[0] + 1);
}

TEST_CASE_TEMPLATE(
    "G7: with strict timing a gap inside a response is seen unless a stall of the program hides it", L,
    whole<tests::stalling_port<scripted_port>, strict>, small<tests::stalling_port<scripted_port>, strict>) {
    constexpr std::uint64_t gap = 2'000;
    constexpr std::uint64_t longest = strict.longest_gap(1).us;
    constexpr std::uint64_t unsure = 200; // between two looks
    unsigned seen = 0;
    unsigned hidden = 0;
    for (std::size_t cut = 1; cut < eight_words.size(); cut += 3) {
        for (std::uint64_t call = 1; call < 4'000; ++call) {
            CAPTURE(cut);
            CAPTURE(call);
            L r;
            r.port.call_us = 20;
            r.port.stalls_at = call;
            r.port.stall_us = 3'000;
            std::uint64_t begins = 0;
            r.port.device = [&](scripted_port& p, const sent_frame& f) {
                std::uint64_t at = f.end + 2'000;
                for (std::size_t i = 0; i < eight_words.size(); ++i) {
                    if (i == cut) begins = at;
                    at += strict.character + (i == cut ? gap : 0u);
                    p.arrive(at, eight_words[i]);
                }
            };
            const errc why = r.ask(read_eight);
            if (r.port.stalls == 0 || r.port.is_over) break;
            // The stall is longer than the gap: the line sees what is before it, or after it.
            const std::uint64_t ends = begins + gap + strict.character;
            const std::uint64_t stalled = r.port.stalled;
            const std::uint64_t goes_on = stalled + r.port.stall_us;
            const bool is_inside = stalled > begins && stalled < ends;
            std::uint64_t visible = is_inside ? stalled - begins : gap + strict.character;
            if (stalled <= begins) visible = goes_on > ends ? 0 : ends - std::max(begins, goes_on);
            const std::uint64_t reading =
                3 * r.port.call_us * cut; // what came before the gap, while it stalled
            if (visible > longest + unsure + reading) {
                CHECK(why == errc::bad_gap);
                ++seen;
            } else if (visible + unsure < longest) {
                CHECK(why == errc::ok);
                ++hidden;
            }
        }
    }
    CHECK(seen > 50);
    CHECK(hidden > 50);
}

} // namespace bytes_at_once_tests
