// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A quarantine follows bytes that came between two requests. It also follows a stop that goes before another
// quarantine: the next request waits for the longer one.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <tests/support/blocking_line_rig.hpp>
#include <tests/support/line_rig.hpp>

namespace quarantines_tests {

using namespace servobus;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;
using tests::waiting_scripted_port;

TEST_CASE_TEMPLATE(
    "G1: four bytes 00 or FF between two requests come from a driver that switches; the fifth, or any "
    "other byte, is followed by a quarantine",
    Port, scripted_port, waiting_scripted_port) {
    struct scene {
        byte_list between;
        bool is_trouble;
    };
    for (const scene& s :
         {scene{{}, false}, scene{{0x00}, false}, scene{{0x00, 0x00, 0x00, 0x00}, false},
          scene{{0xFF, 0xFF, 0xFF, 0xFF}, false}, scene{{0x00, 0xFF, 0x00, 0xFF}, false},
          scene{{0x00, 0x00, 0x00, 0x00, 0x00}, true}, scene{{0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, true},
          scene{{0x01}, true}, scene{{0x00, 0xFE}, true}}) {
        CAPTURE(s.between.size());
        tests::whole_line::rig<Port> r;
        r.settle();
        r.port.device = tests::whole_line::answering(500);
        // Twice: the count begins anew with each request.
        for (int i = 0; i < 2; ++i) {
            CAPTURE(i);
            const std::uint64_t end = r.port.time + s.between.size() * 96;
            r.port.say_at(r.port.time, s.between);
            CHECK(r.run(tests::whole_line::read_one).why.error() == errc::ok);
            CHECK((r.port.frames.back().begin >= end + 100'000) == s.is_trouble);
        }
    }
}

namespace {

/// A request without a response, a stop, and another request. The stop waits for no quarantine, the other one does.
template <class Rig> void follow_a_stop(Rig& r, std::uint32_t late) {
    r.settle();
    r.port.frames.clear();
    // The first request gets a late response or none, the others get theirs in time.
    r.port.device = [late](scripted_port& p, const sent_frame& f) {
        const bool is_first = p.frames.size() == 1;
        if (!is_first) return p.say(500, tests::whole_line::good_response(f.data));
        if (late != 0) p.say(late, tests::blocking::stale);
    };
    r.gaps.quarantine = milliseconds(100);
    REQUIRE(r.run(tests::whole_line::read_one).why.error() == errc::timeout);
    const std::uint64_t over = r.port.time;
    r.priority = priority::stop;
    REQUIRE(r.run(tests::whole_line::write_one).why.error() == errc::ok);
    CHECK(r.port.frames[1].begin <= over + 1750 + 100);
    r.priority = priority::ordinary;
    const std::uint64_t heard = r.port.last_heard;
    // A response to the first request, which came within the quarantine, is none to this one.
    CHECK(r.run(tests::whole_line::read_other).response == tests::whole_line::one_word);
    REQUIRE(r.port.frames.size() == 3);
    CHECK(r.port.frames[2].begin >= heard + 100'000);
    // What follows it waits for no quarantine any more.
    const std::uint64_t ended = r.port.last_heard;
    CHECK(r.run(tests::whole_line::read_one).why.error() == errc::ok);
    CHECK(r.port.frames[3].begin <= ended + 1750 + 100);
}

} // namespace

TEST_CASE_TEMPLATE("G1, G25: a stop goes before a quarantine, and the request after it waits for it", Port,
                   scripted_port, waiting_scripted_port) {
    for (const std::uint32_t late_us : {0u, 130'000u}) { // the limit is 100 ms
        CAPTURE(late_us);
        tests::whole_line::rig<Port> whole;
        follow_a_stop(whole, late_us);
        tests::blocking::rig<tests::blocking::setup<Port>> blocking;
        follow_a_stop(blocking, late_us);
    }
}

} // namespace quarantines_tests
