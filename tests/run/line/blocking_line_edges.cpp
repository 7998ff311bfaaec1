// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The gaps and ends of a blocking line at their edges, one each, by the frames and times on the wire. The other
// `blocking_line_*` tests play each on every kind of port; they run for more than a moment.
#include <doctest/doctest.h>

#include <tests/support/blocking_line_rig.hpp>

namespace blocking_line_edges_tests {

using namespace tests::blocking;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {

constexpr std::uint64_t t3_5 = 1750;
constexpr std::uint64_t quarantine = 100'000;
// A frame begins within so many microseconds of the moment at which it may: the calls of the port, and rest.
constexpr std::uint64_t slack = 200;

const byte_list to_all = framed({0, 6, 0x20, 0x0E, 0, 7});

/// The time from `from` to the begin of the next request, which gets its response.
template <class R> std::uint64_t next_after(R& r, std::uint64_t from, const byte_list& request = read_one) {
    r.port.device = answering(500);
    CHECK(r.ask(request) == errc::ok);
    return r.port.frames.back().begin - from;
}
bool is_about(std::uint64_t time, std::uint64_t wanted) { return time >= wanted && time <= wanted + slack; }

} // namespace

TEST_CASE("G30: after a broadcast the next request waits for nothing more, or as long as after any byte of "
          "trouble") {
    for (const bool is_disturbed : {false, true}) {
        CAPTURE(is_disturbed);
        rig<polls> r;
        r.limits.turnaround = milliseconds(25);
        CHECK(r.bound(to_all) >= 25'000);
        std::uint64_t heard = 0;
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            heard = f.end + 20'000;
            if (is_disturbed) p.arrive(heard, 0x55);
        };
        CHECK(r.ask(to_all) == errc::ok);
        const std::uint64_t sent = r.port.frames.back().end;
        const std::uint64_t gap = next_after(r, is_disturbed ? heard : sent);
        CHECK(is_about(gap, is_disturbed ? quarantine + t3_5 : 25'000));
        CHECK(r.port.frames.size() == 2);
    }
}

TEST_CASE("G30: a broadcast takes no longer than the bound, however long its turnaround") {
    rig<polls> r;
    r.limits.response = milliseconds(10);
    r.limits.turnaround = milliseconds(900);
    (void)r.run_in_time(to_all);
}

TEST_CASE(
    "G1: the request after a good response waits for t3.5, after none for the quarantine, a stop for t3.5") {
    rig<polls> good{answering(500)};
    CHECK(good.ask(read_one) == errc::ok);
    CHECK(is_about(next_after(good, good.port.last_arrival()), t3_5));
    for (const bool is_stop : {false, true}) {
        CAPTURE(is_stop);
        rig<polls> r{[](scripted_port&, const sent_frame&) {}};
        CHECK(r.ask(read_one) == errc::timeout);
        const std::uint64_t ended = r.port.time;
        r.priority = is_stop ? servobus::priority::stop : servobus::priority::ordinary;
        const std::uint64_t gap = next_after(r, ended);
        CHECK(is_about(gap, is_stop ? t3_5 : quarantine + t3_5));
        if (!is_stop) continue;
        const std::uint64_t heard = r.port.last_arrival(); // what follows the stop waits for the quarantine
        r.priority = servobus::priority::ordinary;
        CHECK(next_after(r, heard) >= quarantine);
    }
}

TEST_CASE("G1: a byte while a request waits begins the quarantine anew; one of a switched driver a gap") {
    for (const std::uint8_t byte : {std::uint8_t{0x55}, std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        CAPTURE(byte);
        rig<polls> r{answering(500)};
        CHECK(r.ask(read_one) == errc::ok);
        const std::uint64_t at = r.port.last_arrival() + 1000;
        r.port.arrive(at, byte);
        const std::uint64_t gap = next_after(r, at);
        CHECK(is_about(gap, byte == 0x55 ? quarantine + t3_5 : t3_5));
    }
}

TEST_CASE("G1: 00 in the quarantine begins it anew: it may be of a late response") {
    rig<polls> r{[](scripted_port&, const sent_frame&) {}};
    CHECK(r.ask(read_one) == errc::timeout);
    const std::uint64_t at = r.port.time + 50'000;
    r.port.arrive(at, 0x00);
    CHECK(is_about(next_after(r, at), quarantine + t3_5));
}

TEST_CASE(
    "G2: after a byte of another node while a request leaves a response begins after a gap, not at once") {
    const auto ask = [](std::uint8_t byte, std::uint32_t pause) {
        rig<polls> r;
        r.limits.response = milliseconds(200);
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            p.arrive(f.end - 150, byte);
            p.say_at(f.end + pause, one_word);
        };
        return r.ask(read_one);
    };
    CHECK(ask(0x42, 50) == errc::timeout); // the rest of a frame of that node
    CHECK(ask(0x42, 30'000) == errc::ok);
    CHECK(ask(0x00, 50) == errc::ok); // of a driver that is switched
    CHECK(ask(0xFF, 50) == errc::ok);
}

TEST_CASE("an adapter that receives what it sends, or noise meanwhile, keeps no response away") {
    rig<polls> echo{answering(500)};
    echo.port.echoes = true;
    CHECK(echo.ask(read_one) == errc::ok);
    rig<polls> noisy{saying(one_word, 3000)};
    noisy.port.noisy_until = noisy.port.time + t3_5 + 300;
    CHECK(noisy.ask(read_one) == errc::ok);
}

TEST_CASE("G2: a part of a response before the port is lost is not judged") {
    rig<polls> r;
    r.port.device = [](scripted_port& p, const sent_frame&) {
        p.say(500, byte_list(one_word.begin(), one_word.begin() + 3));
        p.lost_from_call = p.calls + 1500;
    };
    r.limits.response = milliseconds(500);
    CHECK(r.ask(read_one) == errc::port_lost);
}

TEST_CASE("G5: of the bytes before a response so many are skipped as the limits say, and only 00 and FF") {
    for (std::size_t n = 0; n <= 3; ++n) {
        for (const std::uint8_t byte : {std::uint8_t{0x00}, std::uint8_t{0xFF}, std::uint8_t{0x80}}) {
            CAPTURE(n);
            CAPTURE(byte);
            rig<polls> r{saying(byte_list(n, byte) + one_word)};
            r.limits.leading_bytes = 2;
            const bool is_fine = n == 0 || (byte != 0x80 && n <= 2);
            CHECK(r.ask(read_one) == (is_fine ? errc::ok : errc::timeout));
        }
    }
}

TEST_CASE("G2: a response after the frame of another node counts after a gap, of t3.5 where its CRC fits") {
    const byte_list other = tests::read_response(2, {0x1111});
    byte_list bad = other;
    bad.back() ^= 1;
    const auto ask = [](const byte_list& first, std::uint64_t pause) {
        rig<polls> r;
        r.limits.response = milliseconds(200);
        r.port.device = [&](scripted_port& p, const sent_frame&) {
            p.say(500, first);
            p.say_at(p.last_arrival() + pause, one_word);
        };
        return r.ask(read_one);
    };
    CHECK(ask(other, 2'100) == errc::ok);
    CHECK(ask(bad, 2'100) == errc::timeout);
    CHECK(ask(bad, 30'000) == errc::ok);
    rig<polls> two; // the CRC of the second frame is its own
    two.limits.response = milliseconds(200);
    two.port.device = [&](scripted_port& p, const sent_frame&) {
        p.say(500, bad);
        p.say_at(p.last_arrival() + 30'000, other);
        p.say_at(p.last_arrival() + 2'100, one_word);
    };
    CHECK(two.ask(read_one) == errc::ok);
}

TEST_CASE("a port that fails ends the exchange with its error, and the next one is in order") {
    for (const bool is_lost : {false, true}) {
        CAPTURE(is_lost);
        rig<polls> r{answering(500)};
        CHECK(r.ask(read_one) == errc::ok);
        CHECK(r.on.is_echo_ruled_out());
        const auto before = r.on.epoch(1);
        r.port.takes_at_most = 2;
        if (is_lost)
            r.port.lost_from_call = r.port.calls + 2;
        else
            r.port.never_sent = true;
        const status why = r.run(read_one).why;
        CHECK(why.error() == (is_lost ? errc::port_lost : errc::partial_send));
        CHECK((r.on.epoch(1).events.losses != before.events.losses) == is_lost);
        CHECK_FALSE(r.on.is_echo_ruled_out());
        const std::uint64_t failed = r.port.time;
        r.port.lost_from_call = 0;
        r.port.never_sent = false;
        CHECK(next_after(r, failed) >= quarantine);
    }
}

TEST_CASE(
    "a port that takes nothing fails to send within the bound, and one that hears without end is busy") {
    rig<polls> deaf;
    deaf.port.takes_nothing_until = ~std::uint64_t{0};
    const auto unsent = deaf.run_in_time(read_one);
    CHECK(unsent.why.error() == errc::send_failed);
    CHECK_FALSE(unsent.was_sent);
    rig<polls> noisy;
    for (std::uint64_t at = noisy.port.time; at < noisy.port.time + 1'000'000; at += 1000)
        noisy.port.arrive(at, 0x55);
    const auto waited = noisy.run_in_time(read_one);
    CHECK(waited.why.error() == errc::line_busy);
    CHECK_FALSE(waited.was_sent);
}

TEST_CASE("a node whose quarantine is longer than the line's is refused, one as long is not") {
    rig<polls> r{answering(500)};
    r.gaps.quarantine = milliseconds(100);
    CHECK(r.ask(read_one) == errc::ok);
    r.gaps.quarantine = milliseconds(101);
    CHECK(r.ask(read_one) == errc::bad_argument);
}

} // namespace blocking_line_edges_tests
