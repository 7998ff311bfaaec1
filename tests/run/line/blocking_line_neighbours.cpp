// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The blocking line with other nodes that use functions of all kinds: the response is accepted t3.5 after
// their frames, and no part of their frames is ever a response. All times are those of a virtual clock.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <tests/support/blocking_line_rig.hpp>
#include <tests/support/neighbours.hpp>

namespace blocking_line_neighbours_tests {

using namespace tests;
using namespace tests::blocking;
using namespace servobus;

namespace {

std::uint32_t wire(const modbus::rtu_timing& timing, const byte_list& f) {
    return timing.wire_time(f.size()).us;
}

} // namespace

TEST_CASE_TEMPLATE(
    "G11, G41: the response is accepted t3.5 after a frame of another node, of whatever function", S, polls,
    sleeps, polls_strict, sleeps_strict) {
    for (const std::uint8_t code : neighbours::functions) {
        dice random{code};
        const neighbours::pair other = neighbours::pair_of(9, code, {1, 2, 3, 4}, random);
        for (const byte_list& f : {other.response, other.request}) {
            for (const byte_list& q : {read_one, write_one, write_two}) {
                for (const std::uint32_t gap : {S::timing.t3_5 + 50u, 8'000u, 19'000u, 25'000u}) {
                    CAPTURE(static_cast<int>(code));
                    CAPTURE(gap);
                    rig<S> r{[&](scripted_port& p, const sent_frame& sent) {
                        p.say(S::timing.t3_5, f);
                        p.say(S::timing.t3_5 + wire(S::timing, f) + gap, good_response(sent.data));
                    }};
                    r.limits.response = milliseconds(300); // at 9600 Bd some frames are long
                    CHECK(r.ask(q) == errc::ok);
                    CHECK(r.port.frames.size() == 1);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G6, G41: a response inside a frame of function 65h is not accepted, however the frame is cut", S, polls,
    sleeps) {
    for (const byte_list& q : {read_one, write_one}) {
        const byte_list inside = good_response(q);
        for (const std::size_t before : {0u, 1u}) {
            for (const std::size_t zeros : {0u, 3u}) {
                const byte_list all =
                    framed(byte_list{9, 0x65} + byte_list(before, 0x3C) + inside) + byte_list(zeros, 0x00);
                for (std::size_t cut = 1; cut + zeros < all.size(); ++cut) {
                    for (const std::uint32_t pause : {0u, 1'000u, 2'500u, 19'000u}) {
                        for (const bool is_followed : {false, true}) {
                            const auto middle = all.begin() + static_cast<std::ptrdiff_t>(cut);
                            rig<S> r{[&](scripted_port& p, const sent_frame&) {
                                const std::uint32_t end = 5'000 + wire(S::timing, all) + pause;
                                p.say(5'000, {all.begin(), middle});
                                p.say(5'000 + S::timing.wire_time(cut).us + pause, {middle, all.end()});
                                if (is_followed) p.say(end + S::timing.t3_5 + 50, inside);
                            }};
                            REQUIRE(r.ask(q) == (is_followed ? errc::ok : errc::timeout));
                        }
                    }
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE(
    "G6, G41: a frame of another node whose CRC fits in its middle goes on if no pause follows there", S,
    polls, sleeps) {
    for (const std::uint32_t pause : {0u, 500u, 1'500u}) {
        for (const bool is_followed : {false, true}) {
            const byte_list begun = framed({9, 0x65, 1, 2, 3});
            const byte_list whole = framed(begun + one_word);
            rig<S> r{[&](scripted_port& p, const sent_frame&) {
                p.say(5'000, begun);
                p.say(5'000 + wire(S::timing, begun) + pause,
                      {whole.begin() + static_cast<std::ptrdiff_t>(begun.size()), whole.end()});
                if (is_followed)
                    p.say(5'000 + wire(S::timing, whole) + pause + S::timing.t3_5 + 50, one_word);
            }};
            CHECK(r.ask(read_one) == (is_followed ? errc::ok : errc::timeout));
        }
    }
}

TEST_CASE_TEMPLATE(
    "G11, G41: after a frame of another node with a wrong CRC nothing is accepted before a visible gap", S,
    polls, sleeps) {
    for (const std::uint8_t code : neighbours::functions) {
        dice random{code};
        byte_list damaged = neighbours::pair_of(9, code, {1, 2, 3, 4}, random).response;
        damaged.back() ^= 0x20u;
        for (const std::uint32_t gap : {S::timing.t3_5 + 50u, 8'000u, 19'000u, 21'000u}) {
            rig<S> r{[&](scripted_port& p, const sent_frame&) {
                p.say(5'000, damaged);
                p.say(5'000 + wire(S::timing, damaged) + gap, one_word);
            }};
            CHECK(r.ask(read_one) == (gap > 20'000 ? errc::ok : errc::timeout));
        }
    }
}

TEST_CASE_TEMPLATE("G7, G41: in host timing a pause of t3.5 inside a response does not end it", S, polls,
                   sleeps) {
    for (std::size_t cut = 1; cut < one_word.size(); ++cut) {
        const auto middle = one_word.begin() + static_cast<std::ptrdiff_t>(cut);
        rig<S> r{[&](scripted_port& p, const sent_frame&) {
            p.say(2'000, framed({9, 0x65, 1, 2, 3}));
            p.say(8'000, {one_word.begin(), middle});
            p.say(8'000 + S::timing.wire_time(cut).us + 5'000, {middle, one_word.end()});
        }};
        CHECK(r.ask(read_one) == errc::ok);
    }
}

} // namespace blocking_line_neighbours_tests
