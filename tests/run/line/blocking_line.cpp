// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lean line of small cores over a scripted port, and clients on it: that it keeps a client the promises
// that `line` keeps. All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <tests/support/small_rig.hpp>

using namespace tests;
using namespace tests::small;
using namespace servobus;

namespace {

// 40 bytes with a port that has no members (tests/target/small.cpp); the pointer to one that has is 4 more.
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

TEST_CASE_TEMPLATE("a healthy line, also of two wires that hear themselves", S, polls, sleeps, polls_strict,
                   sleeps_strict) {
    for (const bool echoes : {false, true}) {
        rig<S> r{answering(5000)};
        r.port.echoes = echoes;
        for (const byte_list& q : {read_one, write_one, write_two}) {
            const auto e = r.run(q);
            CHECK(e.why == failure{});
            CHECK(e.response == good_response(q));
            CHECK(r.last() == q);
            CHECK(r.on.is_echo_ruled_out());
        }
        r.port.device = nullptr;
        CHECK(r.ask(write_one) == errc::timeout);
    }
}

TEST_CASE("G12: every exception reaches the caller raw, and a read is not repeated for it") {
    for (unsigned n = 0; n <= 255; ++n) {
        rig r{[n](scripted_port& p, const sent_frame& f) {
            p.say(500, tests::exception_response(1, f.data[1], static_cast<std::uint8_t>(n)));
        }};
        REQUIRE(r.fixed.read<position>().why() == failure{errc::exception, static_cast<std::uint8_t>(n)});
        REQUIRE(r.fixed.write<speed>(1).exception() == n);
        REQUIRE(r.open.write<position>(1).outcome() == outcome::refused);
        REQUIRE(r.port.frames.size() == 3);
        REQUIRE(r.on.is_echo_ruled_out());
    }
}

TEST_CASE_TEMPLATE(
    "G1: behind a response that is its request's beginning, and a byte more, there is a quarantine", S, polls,
    sleeps, polls_strict, sleeps_strict) {
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
    "G1: nothing is sent before the line has been silent once, and the quarantine after trouble", S, polls,
    sleeps, polls_strict, sleeps_strict) {
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

TEST_CASE_TEMPLATE(
    "G1: bytes of 00 or FF before a request are a driver that switches, any other byte is trouble", S, polls,
    sleeps) {
    for (const std::uint8_t value : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x01}) {
        for (std::size_t n = 0; n <= 6; ++n) {
            CAPTURE(value);
            CAPTURE(n);
            rig<S> r{answering(500)};
            for (int round = 0; round < 3; ++round) { // they never add up
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
    "G1: what was heard before the last bit left is no response, also if the port gives it in one piece", S,
    polls, sleeps) {
    for (const std::uint32_t cost : {1u, 20u, 60u}) { // 60: a look takes longer than a character
        for (std::uint64_t before = 8 * std::uint64_t{cost} + 192; before < 1500; before += 111) {
            for (std::size_t junk = 0; junk <= 12; ++junk) {
                CAPTURE(cost);
                CAPTURE(before);
                CAPTURE(junk);
                rig<S> r;
                r.port.device = [&](scripted_port& p, const sent_frame& f) {
                    for (const std::uint8_t b : byte_list(junk, 0x33) + stale) p.arrive(f.end - before, b);
                };
                r.port.call_us = cost;
                REQUIRE(r.ask(read_one) != errc::ok);
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G2: a doubled response that begins before the next request has left, or a late one within the "
    "quarantine, is never taken",
    S, polls, sleeps) {
    for (std::uint32_t behind = 0; behind < 2300; behind += 13) { // the next request has left 2518 us later
        CAPTURE(behind);
        rig<S> r{[&](scripted_port& p, const sent_frame& f) {
            if (f.data == read_other) return p.say(500, one_word);
            p.say(500, stale);
            p.say(500 + 7 * 96 + behind, stale);
        }};
        CHECK(r.run(read_one).response == stale);
        const auto e = r.run(read_other);
        CHECK((e.why.code != errc::ok || e.response == one_word));
    }
    for (std::uint32_t late = 2000; late < 99'800; late += 3319) {
        CAPTURE(late);
        rig<S> r{[&](scripted_port& p, const sent_frame& f) {
            p.say(f.data == read_one ? 100'000 + late : 500, f.data == read_one ? stale : one_word);
        }};
        CHECK(r.ask(read_one) == errc::timeout);
        const auto e = r.run(read_other);
        CHECK(e.why.code == errc::ok); // it costs a second silence, not the exchange
        CHECK(e.response == one_word);
    }
}

TEST_CASE_TEMPLATE("G2: each mismatch is an error of its own", S, polls, sleeps, polls_strict,
                   sleeps_strict) {
    struct wrong_response {
        byte_list request;
        byte_list body;
        errc why;
    };
    const byte_list read_three = framed({1, 3, 0x20, 0xA1, 0, 3});
    const errc cut = S::is_strict ? errc::bad_gap : errc::truncated_response;
    for (const wrong_response& w :
         std::vector<wrong_response>{{read_one, {1, 4, 2, 9, 0x60}, errc::wrong_function},
                                     {read_one, {1, 0x84, 2}, errc::wrong_function},
                                     {write_one, {1, 0x10, 0x20, 0x88, 0, 0x64}, errc::wrong_function},
                                     {read_one, {1, 3, 4, 9, 0x60, 1, 1}, errc::wrong_byte_count},
                                     {read_one, {1, 3, 3, 9, 0x60, 1}, errc::wrong_byte_count},
                                     {read_one, {1, 3, 1, 9}, errc::wrong_byte_count},
                                     {read_one, {1, 3, 0}, errc::wrong_byte_count},
                                     {read_three, {1, 3, 2, 9, 0x60}, errc::wrong_byte_count},
                                     {read_three, {1, 3, 8, 1, 2, 3, 4, 5, 6, 7, 8}, errc::wrong_byte_count},
                                     {write_one, {1, 6, 0x20, 0x89, 0, 0x64}, errc::wrong_address},
                                     {write_one, {1, 6, 0x21, 0x88, 0, 0x64}, errc::wrong_address},
                                     {write_one, {1, 6, 0x20, 0x88, 0, 0x65}, errc::wrong_value},
                                     {write_one, {1, 6, 0x20, 0x88, 1, 0x64}, errc::wrong_value},
                                     {write_two, {1, 0x10, 0x20, 0x89, 0, 2}, errc::wrong_address},
                                     {write_two, {1, 0x10, 0x20, 0x88, 0, 4}, errc::wrong_quantity},
                                     {write_two, {1, 0x10, 0x20, 0x88, 2, 2}, errc::wrong_quantity},
                                     {read_one, {2, 3, 2, 9, 0x60}, errc::timeout},
                                     {read_one, {1}, cut}}) {
        CAPTURE(w.body);
        rig<S> r{saying(w.body.size() == 1 ? w.body : framed(w.body))};
        const auto e = r.run_in_time(w.request);
        CHECK(e.why.code == w.why);
        CHECK(written{e.why, e.was_sent}.outcome() == outcome::unknown);
    }
    rig<S> quirk{saying(framed({1, 0x10, 0x20, 0x88, 0, 4}))};
    quirk.limits.echoes_byte_count = true;
    CHECK(quirk.ask(write_two) == errc::ok);
}

TEST_CASE("G2: any single wrong byte of a response gives no success, and a wrong CRC is called so") {
    for (const byte_list& q : {read_one, write_one, write_two}) {
        rig r;
        for (std::size_t at = 0; at < response_size(q); ++at) {
            for (unsigned flip = 1; flip <= 255; ++flip) {
                byte_list response = good_response(q);
                response[at] = static_cast<std::uint8_t>(response[at] ^ flip);
                r.port.device = saying(response);
                const failure why = r.run(q).why;
                REQUIRE(why.code > errc::clock_stopped);
                REQUIRE(why.code != errc::exception);
                if (at >= response.size() - 2) REQUIRE(why.code == errc::bad_crc);
            }
        }
    }
}

TEST_CASE_TEMPLATE("G3: on a line that only echoes no call reports success", S, sleeps, polls,
                   sleeps_strict) {
    for (const std::uint32_t late : {0u, 500u, 40'000u}) {
        for (const std::size_t glitches : {0u, 1u, 3u}) {
            typename S::port port;
            port.character_us = S::timing.character;
            port.device = [&](scripted_port& p, const sent_frame& f) {
                p.say(late, f.data + byte_list(glitches, 0x55));
            };
            typename S::line on{port};
            client<typename S::line, device, fixed_node<device>> drive{on, {}};
            CHECK_FALSE(drive.template read<state>());
            CHECK_FALSE(drive.template read<position>());
            CHECK_FALSE((drive.template read<ramp, speed, position>()));
            CHECK(drive.template write<speed>(1).error() == errc::own_echo);
            CHECK(drive.template write<position>(1).outcome() == outcome::unknown);
            CHECK(drive.template broadcast<speed>(1).outcome() == outcome::done); // nobody need answer
            CHECK(drive.template write<speed>(1).outcome() == outcome::unknown);
            CHECK_FALSE(on.is_echo_ruled_out());
        }
    }
}

TEST_CASE(
    "G3: a read whose echo looks like its response ends as an echo; the response that looks so is taken") {
    unsigned found = 0;
    for (unsigned unit = 1; unit <= 247; ++unit) {
        for (unsigned low = 0; low <= 0xFF; ++low) {
            const byte_list q =
                framed({static_cast<std::uint8_t>(unit), 3, 2, static_cast<std::uint8_t>(low), 0, 1});
            const byte_list response(q.begin(), q.begin() + 7);
            if (framed({response.begin(), response.begin() + 5}) != response) continue;
            ++found;
            rig r{saying(q)};
            REQUIRE(r.ask(q) == errc::own_echo);
            r.port.device = saying(q, 30'000);
            REQUIRE(r.ask(q) == errc::own_echo);
            r.port.device = saying(response);
            const auto e = r.run(q);
            REQUIRE(e.why.code == errc::ok);
            REQUIRE(e.response == response);
            r.port.device = saying(response + byte_list{static_cast<std::uint8_t>(q[7] ^ 1)});
            REQUIRE(r.ask(q) == errc::ok);
        }
    }
    CHECK(found == 248);
}

TEST_CASE("G3, G6: an echo with zeros behind it is no success, although its CRC still fits") {
    for (unsigned words = 2; words <= 10; ++words) {
        CAPTURE(words);
        const byte_list q =
            framed({1, 3, static_cast<std::uint8_t>(2 * words), 0x10, 0, static_cast<std::uint8_t>(words)});
        rig r{saying(q + byte_list(2 * words - 3, 0x00))};
        CHECK(r.ask(q) != errc::ok);
    }
}

TEST_CASE_TEMPLATE("G5: leading bytes are forgiven up to the limit, and make nothing acceptable", S, polls,
                   sleeps, polls_strict, sleeps_strict) {
    byte_list bad = one_word;
    bad[4] ^= 4;
    for (const std::uint8_t most : std::array<std::uint8_t, 3>{0, 1, 4}) {
        for (std::size_t n = 0; n <= 6; ++n) {
            for (const std::uint8_t value : std::array<std::uint8_t, 3>{0x00, 0xFF, 0x80}) {
                rig<S> r{saying(byte_list(n, value) + one_word)};
                r.limits.leading_bytes = most;
                const bool is_fine = n == 0 || (value != 0x80 && n <= most);
                CHECK(r.ask(read_one) == (is_fine ? errc::ok : errc::timeout));
                r.port.device = saying(byte_list(n, value) + bad);
                CHECK(r.ask(read_one) == (is_fine ? errc::bad_crc : errc::timeout));
            }
        }
    }
}

TEST_CASE_TEMPLATE("G6, G9: whatever came before or behind the last response, the next exchange succeeds", S,
                   polls, sleeps, polls_strict, sleeps_strict) {
    tests::dice random{9};
    for (const std::size_t n : {0u, 1u, 4u, 5u, 8u, 33u, 256u, 1000u, 4096u}) {
        for (int kind = 0; kind < 5; ++kind) {
            CAPTURE(n);
            CAPTURE(kind);
            byte_list junk;
            while (junk.size() < n) {
                if (kind < 2) junk.push_back(kind == 0 ? 0x00 : 0xFF);
                if (kind == 2) junk.push_back(random.byte());
                if (kind == 3) junk = junk + stale;
                if (kind == 4) junk = junk + read_one;
            }
            junk.resize(n);
            rig<S> r{answering(500)};
            for (const std::uint8_t b : junk) r.port.arrive(r.port.time, b);
            if (kind % 2 == 0) r.port.time += S::timing.t3_5;
            REQUIRE(r.run(read_one).response == one_word);
            if (n > 300) continue;
            r.port.device = saying(one_word + junk);
            REQUIRE(r.run(read_one).response == one_word);
            r.port.device = answering(500);
            REQUIRE(r.run(read_one).response == one_word);
        }
    }
}

TEST_CASE_TEMPLATE("G7: in host timing a response in bursts of any size, 16 ms apart, is one response", S,
                   polls, sleeps) {
    for (std::size_t size = 1; size <= 7; ++size) {
        for (const std::uint32_t pause : {5000u, 16'000u, 25'000u}) {
            rig<S> r{[&](scripted_port& p, const sent_frame& f) {
                std::uint64_t at = f.end + 1000;
                for (std::size_t i = 0; i < one_word.size(); ++i)
                    p.arrive(at += i % size == 0 ? pause : 0, one_word[i]);
            }};
            CHECK(r.ask(read_one) == (pause < 20'000 || size == 7 ? errc::ok : errc::truncated_response));
        }
    }
}

TEST_CASE_TEMPLATE("G7: in strict timing a response with a gap above t1.5 is rejected", S, polls_strict,
                   sleeps_strict) {
    for (std::size_t cut = 1; cut < one_word.size(); ++cut) {
        for (const std::uint32_t gap : {0u, 1000u, 1650u, 1800u, 4000u, 50'000u}) {
            CAPTURE(cut);
            CAPTURE(gap);
            const auto middle = one_word.begin() + static_cast<std::ptrdiff_t>(cut);
            rig<S> r{[&](scripted_port& p, const sent_frame&) {
                p.say(5000, {one_word.begin(), middle});
                p.say(5000 + cut * S::timing.character + gap, {middle, one_word.end()});
            }};
            CHECK(r.ask(read_one) == (gap <= S::timing.t1_5 ? errc::ok : errc::bad_gap));
        }
    }
}

TEST_CASE_TEMPLATE(
    "G8: a request follows the response before it after t3.5, or the node's gap, and little more", S, polls,
    sleeps, polls_strict, sleeps_strict) {
    for (const std::uint32_t gap : {0u, 500u, 5000u, 40'000u}) {
        for (const std::uint32_t pause : {0u, 1000u, 3000u}) { // of the program between two calls
            CAPTURE(gap);
            CAPTURE(pause);
            rig<S> r{answering(S::timing.t3_5)};
            r.gaps.gap = microseconds(gap);
            const std::uint64_t silence = longer_of({S::timing.t3_5}, r.gaps.gap).us;
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
    "G8: a gap that is longer than the quarantine is kept after trouble too, and is in the bound", S, polls,
    sleeps) {
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

TEST_CASE_TEMPLATE("G8: no byte was heard within t3.5 before a request, however slow the port is", S,
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

TEST_CASE_TEMPLATE("G8: the silence is kept in full when the clock jumps back before a request", S, polls,
                   sleeps) {
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

TEST_CASE("a clock that ticks in milliseconds will do in host timing") {
    rig r{answering(700)};
    r.port.clock = [](std::uint64_t t) { return static_cast<std::uint32_t>(t / 1000 * 1000); };
    for (int i = 0; i < 20; ++i) {
        const std::uint64_t heard = r.port.last_heard;
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames.back().begin + 1000 >= heard + 1750);
    }
}

TEST_CASE_TEMPLATE("G11: another unit's frame neither completes nor aborts nor extends the wait", S, polls,
                   sleeps, polls_strict, sleeps_strict) {
    const byte_list foreign = tests::read_response(2, {0x1111, 0x2222});
    byte_list broken = foreign;
    broken[4] ^= 1;
    for (const byte_list& f :
         {foreign, broken, tests::exception_response(3, 6, 1), framed({9, 6, 0x20, 0x88, 0, 0x64})}) {
        for (const std::uint32_t at : {100u, 3000u, 20'000u}) {
            rig<S> r;
            r.port.say_at(r.port.time, f); // before
            r.port.device = [&](scripted_port& p, const sent_frame& q) {
                p.say(at, f);
                p.say(at + 35'000, good_response(q.data));
            };
            CHECK(r.ask(write_one) == errc::ok);
            CHECK(r.port.frames.size() == 1);
            r.port.device = saying(f, at);
            CHECK(r.ask(write_one) == errc::timeout);
            CHECK(r.port.time >= r.port.frames[1].end + 100'000);
            CHECK(r.port.time <= r.port.frames[1].end + 100'100 + S::timing.t3_5);
        }
    }
}

TEST_CASE_TEMPLATE("an urgent request waits for t3.5, and what follows it for the quarantine", S, polls,
                   sleeps) {
    rig<S> r;
    CHECK(r.ask(read_one) == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.gaps.is_urgent = true;
    r.port.device = answering(500);
    CHECK(r.ask(write_one) == errc::ok);
    CHECK(r.port.frames[1].begin >= over + 1750 - 10);
    CHECK(r.port.frames[1].begin <= over + 1750 + 100);
    r.gaps.is_urgent = false;
    const std::uint64_t heard = r.port.last_heard;
    CHECK(r.ask(read_one) == errc::ok);
    CHECK(r.port.frames[2].begin >= heard + 100'000);
}

TEST_CASE("a node whose quarantine is longer than the line's is refused, and nothing is sent") {
    for (const bool is_urgent : {false, true}) {
        rig r{answering(500)};
        r.open.node().gaps.is_urgent = is_urgent;
        r.open.node().gaps.quarantine = microseconds(100'001);
        CHECK(r.open.read<state>().error() == errc::bad_argument);
        CHECK(r.open.write<position>(1).why() == failure{errc::bad_argument});
        CHECK(r.open.write<position>(1).outcome() == outcome::not_sent);
        CHECK(r.open.broadcast<speed>(1).outcome() == outcome::not_sent);
        CHECK(r.port.frames.empty());
        r.open.node().gaps.quarantine = milliseconds(100);
        CHECK(r.open.read<state>());
        std::array<u16, 2> words{};
        CHECK(r.open.read_words(0xFFFF, words).code == errc::bad_argument); // no frame has it
        CHECK(r.port.frames.size() == 1);
    }
}

TEST_CASE_TEMPLATE("G30: a broadcast returns after the turnaround; what is heard in it is not forgotten", S,
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
        const std::uint64_t heard = r.port.last_arrival();
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.port.frames[2].begin >= heard + 1750);
    }
}
