// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The blocking line over a scripted port: typed access to registers, the gap before each request, the
// quarantine after anything but one valid response, and broadcasts. All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>

namespace blocking_line_gaps_tests {

using namespace tests;
using namespace tests::blocking;
using namespace servobus;

namespace {

// 40 bytes with a port without members (tests/target/small.cpp); the pointer to any other port takes 4 more.
static_assert(sizeof(sleeps::line) + sizeof(rig<>::fixed) <= 44 || sizeof(void*) > 4);
static_assert(sizeof(sleeps::line) + sizeof(rig<>::fixed) <= 4 * sizeof(void*) + 32);

template <class Client> void check_typed_access(rig<>& r, Client& drive) {
    r.serve();
    REQUIRE(drive.template read<state>());
    CHECK(*drive.template read<state>() == 0xBEEF);
    CHECK(r.last() == framed({1, 3, 0x02, 0x00, 0, 1}));
    CHECK(drive.template write<speed>(-300).outcome() == outcome::done);
    CHECK(r.last() == framed({1, 6, 0x01, 0x01, 0xFE, 0xD4}));
    CHECK(drive.template write<position>(-3).outcome() == outcome::done);
    CHECK(r.last() == framed({1, 0x10, 0x01, 0x02, 0, 2, 4, 0xFF, 0xFF, 0xFF, 0xFD}));
    CHECK(drive.template read<position>()->count() == -3);
    CHECK(r.last() == framed({1, 3, 0x01, 0x02, 0, 2}));
    CHECK(drive.template write<ramp, speed>(1000, -2).outcome() == outcome::done);
    CHECK(r.last() == framed({1, 0x10, 0x01, 0x00, 0, 2, 4, 0x03, 0xE8, 0xFF, 0xFE}));
    r.port.frames.clear();
    const auto all = drive.template read<ramp, speed, position>(); // one frame, constant with a fixed node
    REQUIRE(all);
    CHECK(r.port.frames.size() == 1);
    CHECK(r.last() == framed({1, 3, 0x01, 0x00, 0, 4}));
    CHECK(get<ramp>(*all).count() == 1000);
    CHECK(get<speed>(*all).count() == -2);
    CHECK(get<position>(*all).count() == -3);
    const auto two = drive.template read<ramp, state>(); // two requests
    REQUIRE(two);
    CHECK(get<state>(*two) == 0xBEEF);
    CHECK(r.port.frames.size() == 3);
    CHECK(drive.template broadcast<ramp>(77).outcome() == outcome::done); // G30
    CHECK(r.last() == framed({0, 6, 0x01, 0x00, 0, 77}));
    CHECK(drive.template read<ramp>()->count() == 77);
    const std::size_t sent = r.port.frames.size();
    r.port.device = nullptr;
    CHECK((drive.template read<ramp, speed>().error() == errc::timeout));
    CHECK(r.port.frames.size() == sent + 3); // reads are retried
    CHECK(drive.template write<speed>(1).outcome() == outcome::unknown);
    CHECK(drive.template write<position>(1).outcome() == outcome::unknown);
    CHECK(r.port.frames.size() == sent + 5); // G15: writes never
    CHECK(drive.template write<speed>(checked(301)).outcome() == outcome::not_sent);
}

} // namespace

TEST_CASE("typed access: the bytes on the wire, the values, retries of reads and none of writes") {
    rig r;
    SUBCASE("a node of constants") { check_typed_access(r, r.fixed); }
    SUBCASE("a node of variables") { check_typed_access(r, r.open); }
}

TEST_CASE_TEMPLATE(
    "reads and writes succeed on a healthy line, also with an adapter that receives what it sends", S, polls,
    sleeps, polls_strict, sleeps_strict) {
    for (const bool echoes : {false, true}) {
        rig<S> r{answering(5000)};
        r.port.echoes = echoes;
        for (const byte_list& q : {read_one, write_one, write_two}) {
            const auto e = r.run(q);
            CHECK(e.why == errc::ok);
            CHECK(e.response == good_response(q));
            CHECK(r.last() == q);
            CHECK(r.on.is_echo_ruled_out());
        }
        r.port.device = nullptr;
        CHECK(r.ask(write_one) == errc::timeout);
    }
}

TEST_CASE_TEMPLATE(
    "G1: a response that is the beginning of its request, and one byte more, are followed by a quarantine", S,
    polls, sleeps, polls_strict, sleeps_strict) {
    const byte_list request = framed({0x06, 0x03, 0x02, 0x12, 0x00, 0x01});
    const byte_list response{request.begin(), request.begin() + 7};
    REQUIRE(modbus::crc16(response) == 0);
    for (const byte_list& more : {byte_list{}, byte_list{0x5A}}) {
        CAPTURE(more.size());
        rig<S> r;
        r.port.device = saying(response + more);
        CHECK(r.ask(request) == errc::ok);
        const std::uint64_t heard = r.port.last_arrival();
        r.port.device = answering(500);
        CHECK(r.ask(read_one) == errc::ok);
        const bool has_waited = r.port.frames[1].begin >= heard + S::after_trouble - 10;
        CHECK(has_waited == !more.empty());
    }
}

TEST_CASE_TEMPLATE(
    "G1: a blocking line sends nothing before its first quarantine, and before the one after a failure", S,
    polls, sleeps, polls_strict, sleeps_strict) {
    typename S::port fresh;
    typename S::line on{fresh};
    client<typename S::line, device, fixed_node<device>> drive{on, {}};
    const std::uint64_t begun = fresh.time;
    (void)drive.template read<state>();
    CHECK(fresh.frames.at(0).begin >= begun + S::after_trouble - 10);

    byte_list bad_crc = one_word;
    bad_crc.back() ^= 1;
    const std::vector<byte_list> responses{one_word, // i == 0: good, twice
                                           {},
                                           bad_crc,
                                           {one_word.begin(), one_word.begin() + 4},
                                           tests::read_response(2, {1}),
                                           tests::read_response(1, {1, 2}),
                                           tests::acknowledgement(write_one),
                                           byte_list(40, 0x55)};
    for (std::size_t i = 0; i < responses.size(); ++i) {
        for (const bool in_a_burst : {false, true}) {
            CAPTURE(i);
            rig<S> r;
            const byte_list response = i == 0 ? one_word + one_word : responses[i];
            r.port.device = [&](scripted_port& p, const sent_frame& f) {
                if (!in_a_burst) return p.say(500, response);
                for (const std::uint8_t b : response) p.arrive(f.end + 2000, b);
            };
            CHECK((r.ask(read_one) == errc::ok) == (i == 0));
            const std::uint64_t over = i == 0 ? 0 : r.port.time;
            const std::uint64_t heard = r.port.last_arrival();
            r.port.device = answering(500);
            CHECK(r.ask(read_one) == errc::ok);
            CHECK(r.port.frames[1].begin >= (over < heard ? heard : over) + S::after_trouble - 10);
            r.port.device = saying(tests::exception_response(1, 3, 2)); // valid: t3.5 only
            CHECK(r.ask(read_one) == errc::exception);
            const std::uint64_t end = r.port.last_heard;
            CHECK(r.ask(read_one) == errc::exception);
            CHECK(r.port.frames[3].begin >= end + S::timing.t3_5);
            CHECK(r.port.frames[3].begin <= end + S::timing.t3_5 + 40);
        }
    }
}

TEST_CASE_TEMPLATE("G1: bytes 00 or FF before a request come from a driver that switches, any other byte "
                   "causes a quarantine",
                   S, polls, sleeps) {
    for (const std::uint8_t value : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x01}) {
        for (std::size_t n = 0; n <= 6; ++n) {
            CAPTURE(value);
            CAPTURE(n);
            rig<S> r{answering(500)};
            for (int round = 0; round < 3; ++round) { // they do not add up
                const std::uint64_t end = r.port.time + n * 96;
                r.port.say_at(r.port.time, byte_list(n, value));
                CHECK(r.ask(read_one) == errc::ok);
                const bool is_trouble = value == 0x01 && n > 0;
                CHECK((r.port.frames.back().begin >= end + 100'000) == is_trouble);
                CHECK(r.port.frames.back().begin >= (n == 0 ? 0 : end + 1750));
            }
        }
    }
    rig<S> r{answering(500)};
    r.port.noisy_until = r.port.time + 30'000; // garbled characters
    CHECK(r.ask(write_one) == errc::ok);
    CHECK(r.port.frames[0].begin >= r.port.noisy_until + 100'000 - 5100); // a sleep takes 5 ms at most
}

TEST_CASE_TEMPLATE(
    "G8: a blocking line sends a request t3.5, or the node's gap, after the last response, and little later",
    S, polls, sleeps, polls_strict, sleeps_strict) {
    for (const std::uint32_t gap : {0u, 500u, 5000u, 40'000u}) {
        for (const std::uint32_t pause : {0u, 1000u, 3000u}) { // of the program between two calls
            CAPTURE(gap);
            CAPTURE(pause);
            rig<S> r{answering(S::timing.t3_5)};
            r.gaps.gap = microseconds(gap);
            const std::uint64_t silence = longer_of(duration{S::timing.t3_5}, r.gaps.gap).us;
            const std::uint64_t cycle = 15u * S::timing.character + S::timing.t3_5 + silence;
            for (int i = 0; i < 9; ++i) {
                r.port.time += pause;
                const std::uint64_t due = std::max(r.port.last_heard + silence, r.port.time);
                REQUIRE(r.ask(i % 3 == 0 ? write_one : read_one) == errc::ok);
                REQUIRE(r.port.frames.back().begin >= due);
                REQUIRE(r.port.frames.back().begin <= due + cycle / 100 + 12);
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G8: a gap that is longer than the quarantine is also kept after a failure, and is in the bound", S,
    polls, sleeps) {
    rig<S> r;
    r.gaps.gap = milliseconds(250);
    CHECK(r.ask(read_one) == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.port.device = answering(500);
    CHECK(r.ask(read_one) == errc::ok);
    CHECK(r.port.frames.back().begin >= over + 250'000 - 10);
    r.gaps.gap = milliseconds(600);
    const std::uint64_t begun = r.port.time;
    CHECK(r.ask(read_one) == errc::ok);
    CHECK(r.port.time - begun <= r.bound(read_one));
}

TEST_CASE_TEMPLATE(
    "G8: a blocking line has received no byte within t3.5 before a request, however slow the port is", S,
    setup<scripted_port, timing_at(115200, timing_mode::strict), microseconds(0)>,
    setup<waiting_scripted_port, timing_at(115200, timing_mode::strict), microseconds(0)>) {
    struct watched : S::port {
        std::uint64_t heard_before_request = 0;
        transfer send(bytes out) {
            if (this->frames.empty() || this->frames.back().complete) heard_before_request = this->last_heard;
            return S::port::send(out);
        }
    };
    for (const std::uint32_t cost : {0u, 40u, 300u, 600u}) {
        for (std::uint32_t seed = 0; seed < 40; ++seed) {
            CAPTURE(cost);
            CAPTURE(seed);
            rig<setup<watched, S::timing, microseconds(0)>> r{answering(2000)};
            r.port.receive_us = cost;
            r.port.gives_at_most = seed % 2 == 0 ? 1 : 1000;
            tests::dice random{seed};
            std::uint64_t at = r.port.time;
            for (int i = 0; i < 20; ++i) {
                at += random.below(i < 4 ? 4000 : 500);
                r.port.say_at(at, byte_list(1 + random.below(3), random.byte()));
            }
            (void)r.ask(read_one);
            REQUIRE(r.port.frames.size() == 1);
            REQUIRE(r.port.heard_before_request != 0);
            REQUIRE(r.port.frames[0].begin >= r.port.heard_before_request + 1750);
        }
    }
}

TEST_CASE_TEMPLATE("G8: a blocking line keeps the gap in full after bytes that its port was slow to give", S,
                   polls, sleeps) {
    const auto exception = tests::exception_response(1, 3, 2);
    for (const std::uint32_t each : {0u, 60u, 90u, 100u, 150u, 300u}) { // a character takes 96 us
        for (const byte_list& response :
             {one_word, exception, byte_list(one_word.begin(), one_word.end() - 1)}) {
            CAPTURE(each);
            rig<S> r{saying(response)};
            r.port.receive_us = each;
            const errc why = r.ask(read_one);
            const bool is_whole = response.size() != one_word.size() - 1;
            CHECK((why == errc::ok || why == errc::exception) == is_whole);
            const std::uint64_t heard = r.port.last_heard;
            (void)r.ask(read_one);
            CHECK(r.port.frames.at(1).begin >= heard + (is_whole ? S::timing.t3_5 : S::after_trouble - 10));
        }
    }
}

TEST_CASE_TEMPLATE("G7: bytes without a gap are one response, however slow the port is to give them", S,
                   polls, sleeps) {
    for (const std::uint32_t apart : {100u, 1000u, 9000u, 15'000u}) { // less than the 20 ms of a gap
        for (const std::uint32_t each : {0u, 50u, 500u, 2000u}) {
            CAPTURE(apart);
            CAPTURE(each);
            rig<S> r;
            r.port.receive_us = each;
            r.port.device = [&](scripted_port& p, const sent_frame& f) {
                std::uint64_t at = f.end + 40'000;
                for (const std::uint8_t b : one_word) p.arrive(at += apart, b);
            };
            CHECK(r.ask(read_one) == errc::ok);
        }
    }
}

TEST_CASE_TEMPLATE("G8: a blocking line keeps the gap in full when the clock jumps back before a request", S,
                   polls, sleeps) {
    for (const std::uint32_t jump : {1u, 5000u, 1'000'000u, 2'000'000'000u}) {
        for (const bool is_troubled : {false, true}) {
            rig<S> r;
            r.port.time += 3'000'000'000;
            r.settle();
            if (is_troubled) CHECK(r.ask(read_one) == errc::timeout);
            const std::uint64_t at = r.port.time;
            r.port.clock = [at, jump](std::uint64_t t) {
                return static_cast<std::uint32_t>(t < at ? t : t - jump);
            };
            r.port.device = answering(500);
            CHECK(r.ask(read_one) == errc::ok);
            CHECK(r.port.frames.back().begin >= at + (is_troubled ? 100'000 : 1750) - 10);
        }
    }
}

TEST_CASE("a clock that ticks in milliseconds is good enough for a blocking line in host timing") {
    rig r{answering(700)};
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t / 1000 * 1000); };
    for (int i = 0; i < 20; ++i) {
        const std::uint64_t heard = r.port.last_heard;
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames.back().begin + 1000 >= heard + 1750);
    }
}

TEST_CASE_TEMPLATE("a stop frame waits for t3.5, and the request after it for the quarantine", S, polls,
                   sleeps) {
    rig<S> r;
    CHECK(r.ask(read_one) == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.priority = priority::stop;
    r.port.device = answering(500);
    CHECK(r.ask(write_one) == errc::ok);
    CHECK(r.port.frames[1].begin >= over + 1750 - 10);
    CHECK(r.port.frames[1].begin <= over + 1750 + 100);
    r.priority = priority::ordinary;
    const std::uint64_t heard = r.port.last_heard;
    CHECK(r.ask(read_one) == errc::ok);
    CHECK(r.port.frames[2].begin >= heard + 100'000);
}

TEST_CASE("a node whose quarantine is longer than the line's is refused, and nothing is sent") {
    for (const bool is_stop : {false, true}) {
        rig r{answering(500)};
        r.open.node().priority = is_stop ? priority::stop : priority::ordinary;
        r.open.node().gaps.quarantine = microseconds(100'001);
        CHECK(r.open.read<state>().error() == errc::bad_argument);
        CHECK(r.open.write<position>(1) == errc::bad_argument);
        CHECK(r.open.write<position>(1).outcome() == outcome::not_sent);
        CHECK(r.open.broadcast<speed>(1).outcome() == outcome::not_sent);
        CHECK(r.port.frames.empty());
        r.open.node().gaps.quarantine = milliseconds(100);
        CHECK(r.open.read<state>());
        std::array<u16, 2> words{};
        CHECK(r.open.read_words(0xFFFF, words).error() == errc::bad_argument); // fits no frame
        CHECK(r.port.frames.size() == 1);
    }
}

TEST_CASE_TEMPLATE(
    "G30: a broadcast returns after the turnaround, and bytes received meanwhile delay the next request", S,
    polls, sleeps) {
    const byte_list all = framed({0, 6, 0x20, 0x0E, 0, 7});
    rig<S> idle;
    CHECK(idle.ask(framed({0, 3, 0x20, 0x0E, 0, 1})) == errc::bad_argument);
    for (const std::uint32_t early : {2000u, 900u, 200u, 20u}) {
        CAPTURE(early);
        rig<S> r;
        r.limits.turnaround = milliseconds(25);
        CHECK(r.ask(all) == errc::ok);
        CHECK(r.port.time >= r.port.frames[0].end + 25'000);
        CHECK(r.port.time <= r.port.frames[0].end + 25'060 + (waiting_port<typename S::port> ? 1750 : 0));
        const device_script answers = answering(500);
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            if (f.data == all) return p.arrive(f.end + 25'000 - early, 0x55);
            answers(p, f);
        };
        CHECK(r.ask(all) == errc::ok);
        // A good end needs no quarantine, and the turnaround was longer than the gap.
        CHECK(r.port.frames[1].begin <= r.port.frames[0].end + 25'120 + 1750);
        const std::uint64_t heard = r.port.last_arrival();
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames[2].begin >= heard + 1750);
    }
}

} // namespace blocking_line_gaps_tests
