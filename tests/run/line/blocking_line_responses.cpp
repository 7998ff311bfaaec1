// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The blocking line over a scripted port: what it accepts as a response. Wrong, late and damaged responses,
// exceptions, the line's own echo, noise before and after a response, responses in pieces, and frames of
// other nodes. All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>

namespace blocking_line_responses_tests {

using namespace tests;
using namespace tests::blocking;
using namespace servobus;

TEST_CASE("G12: every exception reaches the caller unchanged, and its read is not repeated") {
    for (unsigned n = 0; n <= 255; ++n) {
        rig r{[n](scripted_port& p, const sent_frame& f) {
            p.say(500, tests::exception_response(1, f.data[1], static_cast<std::uint8_t>(n)));
        }};
        const errc why = n == 5 ? errc::acknowledged : errc::exception;
        REQUIRE(r.fixed.read<position>().status() == status::sent(why, static_cast<std::uint8_t>(n)));
        REQUIRE(r.fixed.write<speed>(1).exception() == n);
        REQUIRE(r.open.write<position>(1).outcome() == (n == 5 ? outcome::unknown : outcome::refused));
        REQUIRE(r.port.frames.size() == 3);
        REQUIRE(r.on.is_echo_ruled_out());
    }
}

TEST_CASE_TEMPLATE("G1: bytes received before the last bit left are no response, also if the port delivers "
                   "them in one piece",
                   S, polls, sleeps) {
    for (const std::uint32_t cost : {1u, 20u, 60u}) { // 60: a call takes longer than a character
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

TEST_CASE_TEMPLATE("G2: a doubled response that begins before the next request has left, or a late one "
                   "within the quarantine, is never accepted",
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
        CHECK((e.why.error() != errc::ok || e.response == one_word));
    }
    for (std::uint32_t late = 2000; late < 99'800; late += 3319) {
        CAPTURE(late);
        rig<S> r{[&](scripted_port& p, const sent_frame& f) {
            p.say(f.data == read_one ? 100'000 + late : 500, f.data == read_one ? stale : one_word);
        }};
        CHECK(r.ask(read_one) == errc::timeout);
        const auto e = r.run(read_other);
        CHECK(e.why.error() == errc::ok); // it costs a second quarantine, not the exchange
        CHECK(e.response == one_word);
    }
}

TEST_CASE_TEMPLATE("G2: each mismatch has its own error", S, polls, sleeps, polls_strict, sleeps_strict) {
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
        CHECK(e.why.error() == w.why);
        CHECK(e.why.outcome() == outcome::unknown);
    }
    rig<S> quirk{saying(framed({1, 0x10, 0x20, 0x88, 0, 4}))};
    quirk.limits.echoes_byte_count = true;
    CHECK(quirk.ask(write_two) == errc::ok);
}

TEST_CASE("G2: no single wrong byte of a response gives success, and a wrong CRC is reported as one") {
    for (const byte_list& q : {read_one, write_one, write_two}) {
        rig r;
        for (std::size_t at = 0; at < response_size(q); ++at) {
            for (unsigned flip = 1; flip <= 255; ++flip) {
                byte_list response = good_response(q);
                response[at] = static_cast<std::uint8_t>(response[at] ^ flip);
                r.port.device = saying(response);
                const status why = r.run(q).why;
                REQUIRE(why.error() > errc::clock_stopped);
                REQUIRE(why.error() != errc::exception);
                if (at >= response.size() - 2) REQUIRE(why.error() == errc::bad_crc);
            }
        }
    }
}

TEST_CASE_TEMPLATE("G3: on a line that only echoes no call of a client reports success", S, sleeps, polls,
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
            CHECK(drive.template broadcast<speed>(1).outcome() == outcome::done); // needs no response
            CHECK(drive.template write<speed>(1).outcome() == outcome::unknown);
            CHECK_FALSE(on.is_echo_ruled_out());
        }
    }
}

TEST_CASE("G3: a read whose echo looks like its response ends as an echo; a response that looks like this is "
          "accepted") {
    unsigned found = 0;
    for (unsigned node_address = 1; node_address <= 247; ++node_address) {
        for (unsigned low = 0; low <= 0xFF; ++low) {
            const byte_list q =
                framed({static_cast<std::uint8_t>(node_address), 3, 2, static_cast<std::uint8_t>(low), 0, 1});
            const byte_list response(q.begin(), q.begin() + 7);
            if (framed({response.begin(), response.begin() + 5}) != response) continue;
            ++found;
            rig r{saying(q)};
            REQUIRE(r.ask(q) == errc::own_echo);
            r.port.device = saying(q, 30'000);
            REQUIRE(r.ask(q) == errc::own_echo);
            r.port.device = saying(response);
            const auto e = r.run(q);
            REQUIRE(e.why.error() == errc::ok);
            REQUIRE(e.response == response);
            r.port.device = saying(response + byte_list{static_cast<std::uint8_t>(q[7] ^ 1)});
            REQUIRE(r.ask(q) == errc::ok);
        }
    }
    CHECK(found == 248);
}

TEST_CASE("G3, G6: an echo followed by zeros is no success, although its CRC still fits") {
    for (unsigned words = 2; words <= 10; ++words) {
        CAPTURE(words);
        const byte_list q =
            framed({1, 3, static_cast<std::uint8_t>(2 * words), 0x10, 0, static_cast<std::uint8_t>(words)});
        rig r{saying(q + byte_list(2 * words - 3, 0x00))};
        CHECK(r.ask(q) != errc::ok);
    }
}

TEST_CASE_TEMPLATE("G5: leading bytes are skipped up to the limit, and make no bad response valid", S, polls,
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

TEST_CASE_TEMPLATE("G6, G9: whatever precedes or follows the last response, the next exchange succeeds", S,
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

TEST_CASE_TEMPLATE("G7: in host timing a blocking line accepts a response in bursts of any size, 16 ms apart",
                   S, polls, sleeps) {
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

TEST_CASE_TEMPLATE("G7: in strict timing a blocking line rejects a response with a gap above t1.5", S,
                   polls_strict, sleeps_strict) {
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

TEST_CASE_TEMPLATE("G11: another node's frame neither completes nor aborts nor extends the wait", S, polls,
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

} // namespace blocking_line_responses_tests
