// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The tool's listener pairs requests and responses of others, and counts them.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <examples/servobus/capture/conversation.hpp>

namespace conversation_tests {

using servobus::direction;
using servobus::hex;
using tool::conversation;
using tool::heard;
using tool::moment;
using tool::piece;
using enum servobus::direction;

namespace {

constexpr moment ms = 1000;

struct bench {
    conversation frames{100 * ms};

    heard take(moment at, servobus::bytes data, piece::kind what = piece::kind::frame) {
        return frames.take({what, {data.begin(), data.end()}, at, at + ms});
    }
    heard damaged(moment at, servobus::bytes data) { return take(at, data, piece::kind::bad_crc); }
    const tool::node_counters& node(std::size_t address) const { return frames.counters()[address]; }
    // Each request has exactly one end, but for the last one.
    void check_sums(std::size_t address, std::uint64_t waiting = 0) const {
        const tool::node_counters& c = node(address);
        CHECK(c.requests == c.responses + c.exceptions + c.no_response + c.damaged + waiting);
    }
};

constexpr auto read_speeds = hex("01 03 20 AB 00 02 BE 2B");
constexpr auto speeds = hex("01 03 04 00 64 00 64 BA 07");
constexpr auto enable = hex("01 06 20 0E 00 08 E2 0F");
constexpr auto stop = hex("01 06 20 0E 00 07 A2 0B");
constexpr auto read_empty = hex("01 03 00 3C 00 01 44 06");
constexpr auto refused = hex("01 83 03 01 31");
constexpr auto write_two = hex("01 10 20 30 00 02 04 04 00 00 00 68 4A");
constexpr auto written_two = hex("01 10 20 30 00 02 4A 07");

} // namespace

TEST_CASE("listen: requests and responses are paired, with the time between them") {
    bench b;
    CHECK(b.take(0, read_speeds).way == request);
    const heard h = b.take(5 * ms, speeds);
    CHECK(h.way == response);
    CHECK(h.after == 4 * ms);
    CHECK_FALSE(h.is_unpaired);
    CHECK(b.take(10 * ms, enable).way == request);
    CHECK(b.take(13 * ms, enable).way == response);
    CHECK(b.take(20 * ms, write_two).way == request);
    CHECK(b.take(30 * ms, written_two).after == 9 * ms);
    CHECK(b.take(40 * ms, read_empty).way == request);
    CHECK(b.take(50 * ms, refused).after == 9 * ms);
    CHECK(b.node(1).requests == 4);
    CHECK(b.node(1).responses == 3);
    CHECK(b.node(1).exceptions == 1);
    CHECK(b.node(1).slowest == 9 * ms);
    b.check_sums(1);
}

TEST_CASE("listen: a request without a response is said once") {
    bench b;
    (void)b.take(0, read_speeds);
    CHECK_FALSE(b.frames.overdue(101 * ms));
    CHECK(b.frames.overdue(101 * ms + 1) == 1);
    CHECK_FALSE(b.frames.overdue(500 * ms));
    SUBCASE("and the next request does not say it again") {
        CHECK_FALSE(b.take(500 * ms, read_speeds).unanswered);
        CHECK(b.node(1).no_response == 1);
        b.check_sums(1, 1);
    }
    SUBCASE("a late response is one all the same") {
        CHECK(b.take(500 * ms, speeds).after == 499 * ms);
        CHECK(b.node(1).no_response == 0);
        CHECK(b.node(1).responses == 1);
        b.check_sums(1);
    }
}

TEST_CASE("listen: a client that repeats a request before the timeout has got no response either") {
    bench b;
    (void)b.take(0, read_speeds);
    CHECK(b.take(50 * ms, read_speeds).unanswered == 1);
    CHECK(b.take(55 * ms, speeds).after == 4 * ms);
    CHECK(b.node(1).no_response == 1);
    b.check_sums(1);
}

TEST_CASE("listen: a write is repeated after the timeout, and responded to before it") {
    bench b;
    (void)b.take(0, read_speeds);
    (void)b.take(5 * ms, speeds);
    CHECK(b.take(10 * ms, enable).way == request);
    (void)b.frames.overdue(300 * ms);
    CHECK(b.take(300 * ms, enable).way == request);
    CHECK(b.take(310 * ms, enable).way == response);
    CHECK(b.take(320 * ms, enable).way == request);
    CHECK(b.take(330 * ms, stop).way == request); // not the response of enable
    CHECK(b.take(340 * ms, stop).way == response);
    CHECK(b.node(1).no_response == 2);
    b.check_sums(1);
}

TEST_CASE("listen: as it begins, a write of one register has no direction") {
    bench b;
    CHECK(b.take(0, enable).way == unknown);
    CHECK(b.node(1).unpaired == 1);
    SUBCASE("the same again soon is its response") {
        CHECK(b.take(5 * ms, enable).after == 4 * ms);
        CHECK(b.node(1).unpaired == 0);
        CHECK(b.take(50 * ms, enable).way == request);
        CHECK(b.take(55 * ms, enable).way == response);
        b.check_sums(1);
    }
    SUBCASE("the same again late is a request: the first was a response") {
        CHECK(b.take(500 * ms, enable).way == request);
        CHECK(b.take(505 * ms, enable).way == response);
        CHECK(b.node(1).unpaired == 1);
        b.check_sums(1);
    }
    SUBCASE("so is another one") {
        CHECK(b.take(5 * ms, stop).way == request);
        CHECK(b.take(9 * ms, stop).way == response);
        CHECK(b.node(1).no_response == 0);
    }
    SUBCASE("after damaged bytes again") {
        (void)b.damaged(3 * ms, hex("01 06 20 0E 00 08 E2 0E"));
        CHECK(b.take(8 * ms, enable).way == unknown);
        CHECK(b.node(1).unpaired == 2);
    }
    SUBCASE("and a read is one in any case") {
        CHECK(b.take(5 * ms, read_speeds).way == request);
        CHECK_FALSE(b.take(9 * ms, speeds).is_unpaired);
        CHECK(b.node(1).no_response == 0);
    }
}

TEST_CASE("listen: a damaged response is neither a response nor none") {
    bench b;
    (void)b.take(0, read_speeds);
    (void)b.take(5 * ms, speeds);
    (void)b.take(10 * ms, enable);
    (void)b.damaged(15 * ms, hex("01 06 20 0E 00 08 E2 0E"));
    CHECK(b.node(1).damaged == 1);
    CHECK_FALSE(b.frames.overdue(500 * ms));
    CHECK(b.take(20 * ms, enable).way == request); // it is repeated
    CHECK(b.take(25 * ms, enable).way == response);
    (void)b.take(30 * ms, read_speeds);
    (void)b.damaged(31 * ms, hex("55 55 55 55 55"));
    CHECK(b.take(35 * ms, speeds).after == 4 * ms); // that was noise
    CHECK(b.node(1).damaged == 1);
    b.check_sums(1);
}

TEST_CASE("listen: a glitch of a switching driver changes nothing") {
    bench b;
    (void)b.take(0, read_speeds);
    (void)b.take(5 * ms, speeds);
    CHECK(b.take(10 * ms, enable).way == request);
    (void)b.take(14 * ms, hex("FF"), piece::kind::noise);
    CHECK(b.take(15 * ms, enable).way == response);
    (void)b.take(19 * ms, hex("00"), piece::kind::noise);
    CHECK(b.take(20 * ms, enable).way == request);
    b.check_sums(1, 1);
}

TEST_CASE("listen: after damaged bytes that may have been a request, a write has no direction") {
    bench b;
    (void)b.take(0, read_speeds);
    (void)b.take(5 * ms, speeds);
    (void)b.damaged(10 * ms, hex("01 06 20 0E 00 08 E2 0E"));
    CHECK(b.take(15 * ms, enable).way == unknown);
    CHECK(b.take(20 * ms, read_speeds).way == request);
    CHECK(b.node(1).no_response == 0);
}

TEST_CASE("listen: responses that belong to no request") {
    bench b;
    CHECK(b.take(0, speeds).is_unpaired); // listening began after the request
    CHECK(b.take(10 * ms, read_speeds).way == request);
    CHECK_FALSE(b.take(15 * ms, speeds).is_unpaired);
    CHECK(b.take(16 * ms, speeds).is_unpaired); // a second one
    CHECK(b.take(20 * ms, hex("02 03 20 AB 00 02 BE 18")).way == request);
    CHECK(b.take(25 * ms, speeds).is_unpaired); // another node's
    CHECK(b.frames.overdue(500 * ms) == 2);
    CHECK(b.take(600 * ms, read_empty).way == request);
    CHECK(b.take(610 * ms, speeds).is_unpaired); // of two words, one was asked for
    CHECK(b.take(620 * ms, refused).after == 19 * ms);
    CHECK(b.take(630 * ms, write_two).way == request);
    CHECK(b.take(640 * ms, speeds).is_unpaired);                         // of another function
    CHECK(b.take(650 * ms, hex("01 10 20 8A 00 04 EB E0")).is_unpaired); // of other registers
    CHECK(b.take(660 * ms, written_two).after == 29 * ms);
    CHECK(b.node(1).unpaired == 6);
    b.check_sums(1);
    b.check_sums(2);
}

TEST_CASE("listen: a broadcast has no response, and none is missed") {
    bench b;
    constexpr auto to_all = servobus::modbus::write_frame(0, 0x200E, 7);
    CHECK(b.take(0, to_all).way == request);
    CHECK_FALSE(b.frames.overdue(500 * ms));
    CHECK(b.take(600 * ms, to_all).way == request);
    CHECK(b.node(0).requests == 2);
    CHECK(b.node(0).no_response == 0);
}

TEST_CASE("listen: other functions and frames that are not well-formed are paired too") {
    bench b;
    (void)b.take(0, read_speeds);
    (void)b.take(1 * ms, speeds);
    CHECK(b.take(10 * ms, hex("01 02 00 00 00 04 79 C9")).way == request);
    CHECK(b.take(15 * ms, hex("01 82 02 C1 61")).after == 4 * ms);
    CHECK(b.take(16 * ms, hex("01 02 00 00 00 04 79 C9")).way == request);
    std::uint8_t four_inputs[6] = {1, 2, 1, 5};
    REQUIRE(servobus::modbus::close_frame(four_inputs, 3) == 6);
    CHECK(b.take(18 * ms, four_inputs).after == 1 * ms);
    // The byte count is 12, 13 bytes follow.
    CHECK(b.take(20 * ms, hex("01 10 00 21 00 05 0C 00 0A 00 64 00 64 00 3C 00 00 00 03 E8 04 76")).way ==
          request);
    CHECK(b.take(30 * ms, hex("01 10 00 21 00 05 50 00")).after == 9 * ms);
    // A read of no registers, twice.
    CHECK(b.take(40 * ms, hex("01 03 20 AB 00 00 3F EA")).way == request);
    CHECK(b.take(50 * ms, hex("01 03 20 AB 00 00 3F EA")).way == request);
    CHECK(b.take(60 * ms, hex("01 83 03 01 31")).after == 9 * ms);
    b.check_sums(1);
}

} // namespace conversation_tests
