// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line over a scripted port that receives more than its responses: noise before, in and after a response,
// frames of other nodes, late responses, the line's own echo, and responses that arrive in pieces. All times
// are those of a virtual clock.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/line_rig.hpp>

namespace line_noise_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::waiting_scripted_port;
using tests::operator+;

TEST_CASE_TEMPLATE("G9: whatever came before, 0..4096 bytes of any kind, the next exchange succeeds", Port,
                   scripted_port, waiting_scripted_port) {
    tests::dice random{9};
    for (const std::size_t n :
         {0u, 1u, 2u, 5u, 8u, 31u, 32u, 33u, 64u, 255u, 256u, 257u, 1000u, 4095u, 4096u}) {
        for (int kind = 0; kind < 5; ++kind) {
            CAPTURE(n);
            CAPTURE(kind);
            byte_list junk;
            while (junk.size() < n) {
                if (kind == 0) junk.push_back(0x00);
                if (kind == 1) junk.push_back(0xFF);
                if (kind == 2) junk.push_back(random.byte());
                if (kind == 3) junk = junk + tests::read_response(1, {0xDEAD});
                if (kind == 4) junk = junk + read_one;
            }
            junk.resize(n);
            for (const bool is_settled : {false, true}) {
                for (const bool is_old : {false, true}) {
                    rig<Port> r;
                    if (is_settled) r.settle();
                    r.port.device = answering(500);
                    for (const std::uint8_t b : junk) r.port.arrive(r.port.time, b);
                    if (is_old) r.port.time += 1750;
                    const auto e = r.run(read_one);
                    REQUIRE(e.why.error() == errc::ok);
                    REQUIRE(e.response == one_word);
                    if (!is_settled || n > 0) REQUIRE(r.port.frames[0].begin >= 1750);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE("G9: 4096 bytes of noise at the line's own speed end in line_busy at most, and then the "
                   "next exchange succeeds",
                   Port, scripted_port, waiting_scripted_port) {
    tests::dice random{10};
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    byte_list junk(4096);
    for (auto& b : junk) b = random.byte();
    r.port.say_at(r.port.time, junk);
    const auto e = r.run(write_one);
    CHECK(e.why.error() == errc::line_busy);
    CHECK_FALSE(e.was_sent);
    CHECK(r.port.frames.empty());
    r.port.time = r.port.last_arrival() + 1750;
    CHECK(r.run(write_one).why.error() == errc::ok);
}

TEST_CASE_TEMPLATE("G6: trailing bytes, also many 00, do not disturb the next exchange", Port, scripted_port,
                   waiting_scripted_port) {
    tests::dice random{6};
    for (const std::size_t n : {1u, 4u, 5u, 40u, 300u}) {
        for (int kind = 0; kind < 3; ++kind) {
            CAPTURE(n);
            CAPTURE(kind);
            byte_list tail(n, kind == 0 ? std::uint8_t{0} : std::uint8_t{0xFF});
            if (kind == 2) {
                for (auto& b : tail) b = random.byte();
            }
            rig<Port> r;
            r.settle();
            bool is_first = true;
            r.port.device = [&](auto& port, const tests::sent_frame& f) {
                port.say(500, is_first ? good_response(f.data) + tail : good_response(f.data));
                is_first = false;
            };
            CHECK(r.run(read_one).response == one_word);
            const auto e = r.run(read_one);
            CHECK(e.why.error() == errc::ok);
            CHECK(e.response == one_word);
        }
    }
}

TEST_CASE_TEMPLATE(
    "G11: frames of another node before a request and during its wait neither complete nor abort it", Port,
    scripted_port, waiting_scripted_port) {
    const byte_list foreign = tests::read_response(2, {0x1111, 0x2222});
    byte_list broken = foreign;
    broken[4] ^= 1;
    for (const byte_list& f :
         {foreign, broken, tests::exception_response(3, 6, 1), framed({9, 6, 0x20, 0x88, 0, 0x64})}) {
        for (const std::uint32_t at : {100u, 3000u, 20'000u}) {
            rig<Port> r;
            r.settle();
            r.port.say_at(r.port.time, f); // before
            r.port.device = [&](auto& port, const tests::sent_frame& q) {
                port.say(at, f);
                port.say(at + 30'000, good_response(q.data));
            };
            const auto e = r.run(write_one);
            CHECK(e.why.error() == errc::ok);
            CHECK(r.port.frames.size() == 1);
            r.port.device = [&](auto& port, const tests::sent_frame&) { port.say(at, f); };
            const std::uint64_t expected_end = 100'000;
            const auto alone = r.run(write_one);
            CHECK(alone.why.error() == errc::timeout);
            CHECK(r.port.time >= r.port.frames[1].end + expected_end);
            CHECK(r.port.time <= r.port.frames[1].end + expected_end + 100);
        }
    }
}

TEST_CASE_TEMPLATE("a garbled character before the request only delays it", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.device = answering(500);
    const std::uint64_t garbled_until = r.port.time + 30'000;
    r.port.noisy_until = garbled_until;
    const auto e = r.run(write_one);
    CHECK(e.why.error() == errc::ok);
    CHECK(r.port.frames.size() == 1);
    // Another device may have sent: quarantine. A port that sleeps is checked every 5 ms.
    CHECK(r.port.frames[0].begin >= garbled_until + 100'000 - 6000);
}

TEST_CASE_TEMPLATE("a receiver that fails for ever ends in line_busy, within the bound", Port, scripted_port,
                   waiting_scripted_port) {
    rig<Port> r;
    r.settle();
    r.port.noisy_until = ~std::uint64_t{0};
    const std::uint64_t begun = r.port.time;
    const auto e = r.run(read_one);
    CHECK(e.why.error() == errc::line_busy);
    CHECK_FALSE(e.was_sent);
    CHECK(r.port.time - begun <= r.bound(read_one, 7));
}

TEST_CASE_TEMPLATE(
    "G2: a late response within its node's quarantine is dropped, whichever node was asked in between", Port,
    scripted_port, waiting_scripted_port) {
    const byte_list stale = tests::read_response(1, {0xDEAD});
    const byte_list read_two = framed({0x02, 0x03, 0x20, 0xA1, 0x00, 0x01});
    for (std::uint32_t late = 22'000; late < 30'000; late += 97) {
        CAPTURE(late);
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            if (f.data == read_one) port.say(100'000 + late, stale);
            if (f.data == read_two) port.say(500, tests::read_response(2, {7}));
        };
        CHECK(r.run(read_one).why.error() == errc::timeout);
        r.gaps.quarantine = milliseconds(20); // the other node's
        (void)r.run(read_two);
        r.gaps.quarantine = milliseconds(100);
        CHECK(r.run(read_other).why.error() != errc::ok);
    }
}

TEST_CASE_TEMPLATE("the line's own echo is dropped while the request leaves, and is no response", Port,
                   scripted_port, waiting_scripted_port) {
    for (const byte_list& request : {read_one, write_one, write_two}) {
        rig<Port> r;
        r.port.echoes = true;
        r.settle();
        CHECK(r.run(request).why.error() == errc::timeout);
        r.port.device = answering(500);
        CHECK(r.run(request).why.error() == errc::ok);
    }
}

TEST_CASE_TEMPLATE("G7: in host timing a line accepts a response in bursts of any size, 16 ms apart", Port,
                   scripted_port, waiting_scripted_port) {
    for (std::size_t size = 1; size <= 7; ++size) {
        rig<Port> r;
        r.settle();
        r.port.device = [&](auto& port, const tests::sent_frame& f) {
            std::uint64_t at = f.end + 1000;
            for (std::size_t i = 0; i < one_word.size(); ++i) {
                if (i % size == 0) at += 16'000;
                port.arrive(at, one_word[i]);
            }
        };
        const auto e = r.run(read_one);
        CHECK(e.why.error() == errc::ok);
        CHECK(e.response == one_word);
    }
}

TEST_CASE_TEMPLATE("G7: in strict timing the line rejects a response with a gap above t1.5", Port,
                   scripted_port, waiting_scripted_port) {
    for (std::size_t cut = 1; cut < one_word.size(); ++cut) {
        for (const std::uint32_t gap : {0u, 1000u, 1600u, 1900u, 4000u, 50'000u}) {
            CAPTURE(cut);
            CAPTURE(gap);
            rig<Port> r{timing_at(9600, timing_mode::strict)};
            r.settle();
            const auto middle = one_word.begin() + static_cast<std::ptrdiff_t>(cut);
            r.port.device = [&](auto& port, const tests::sent_frame& f) {
                port.say(5000, byte_list(one_word.begin(), middle));
                const auto first = static_cast<std::uint32_t>(cut) * r.timing.character;
                port.say_at(f.end + 5000 + first + gap, byte_list(middle, one_word.end()));
            };
            const auto e = r.run(read_one);
            CHECK(e.why.error() == (gap <= r.timing.t1_5 ? errc::ok : errc::bad_gap));
        }
    }
}

} // namespace line_noise_tests
