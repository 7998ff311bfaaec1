// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line and its users when something fails between them: an owner that returns after its hold timeout, one
// that abandons its request in the middle of a frame, tickets that wrap, a clock that goes back.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

namespace line_faults_tests {

using namespace servobus;
using modbus::exchange;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list write_one = framed({0x01, 0x06, 0x20, 0x88, 0x00, 0x64});
const byte_list one_word = tests::read_response(1, {0x0960});
const byte_list stop_all = framed({0x00, 0x06, 0x20, 0x0E, 0x00, 0x07});

struct rig {
    scripted_port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(100)};
    line<scripted_port> on{port, modbus::timing_at(115200)};
    std::array<std::array<std::uint8_t, 16>, 3> room{};

    rig() { port.device = answer; }
    rig(const rig&) = delete;

    static void answer(scripted_port& p, const tests::sent_frame& f) {
        if (f.data[0] == 1) p.say(500, f.data[1] == 0x03 ? one_word : tests::acknowledgement(f.data));
    }
    exchange make(const byte_list& request, std::size_t which) {
        return {request, room[which], on.timing(), limits};
    }
    void finish(exchange& x) {
        while (!x.done()) on.step(x, gaps);
    }
    /// The line as it is after a good exchange.
    void settle() {
        exchange x = make(read_one, 2);
        finish(x);
        REQUIRE(x.status() == errc::ok);
        port.frames.clear();
    }
    std::uint64_t bound() const { return on.bound(8, 8, limits, gaps).us; }
};

} // namespace

TEST_CASE(
    "an exchange that is stepped again after its hold timeout ends with a timeout, and the line goes on") {
    for (const bool by_run : {false, true}) {
        CAPTURE(by_run);
        rig r;
        r.settle();
        exchange late = r.make(write_one, 0);
        while (late.state() != exchange::phase::awaiting) r.on.step(late, r.gaps);
        r.port.time += 2 * r.bound();
        exchange next = r.make(read_one, 1);
        while (next.state() != exchange::phase::awaiting) r.on.step(next, r.gaps);
        if (by_run) {
            r.on.run(late, r.gaps);
        } else {
            r.on.step(late, r.gaps);
        }
        CHECK(late.done());
        CHECK(late.status().error() == errc::timeout);
        CHECK(late.was_sent()); // so the write is unknown, not undone
        CHECK_FALSE(r.on.is_free());
        r.finish(next);
        CHECK(next.status() == errc::ok);
        CHECK(same_bytes(next.response(), one_word));
        CHECK(r.port.frames.size() == 2);
    }
}

TEST_CASE("an exchange that is stepped again on a line that has become free does not take what has arrived") {
    for (const bool by_run : {false, true}) {
        CAPTURE(by_run);
        rig r;
        r.settle();
        exchange late = r.make(write_one, 0);
        while (late.state() != exchange::phase::awaiting) r.on.step(late, r.gaps);
        r.port.time += 2 * r.bound();
        CHECK(r.on.is_free()); // after the hold timeout
        if (by_run) {
            r.on.run(late, r.gaps);
        } else {
            r.on.step(late, r.gaps);
        }
        CHECK(late.status().error() == errc::timeout);
        CHECK(late.was_sent());
        CHECK(r.on.is_free());
        const std::uint64_t over = r.port.time;
        exchange next = r.make(read_one, 1);
        r.finish(next);
        CHECK(same_bytes(next.response(), one_word)); // not the write's, which came before
        CHECK(r.port.frames.back().begin >= over + 100'000 - 20);
    }
}

TEST_CASE("G21: a request that left and got no valid response invalidates the state of its drive, once, "
          "however it ends") {
    rig r;
    r.settle();
    const std::uint16_t before = r.on.epoch(1).misses;
    const std::uint16_t other = r.on.epoch(2).misses;
    exchange x = r.make(read_one, 0);
    unsigned bus_gaps = 1;
    constexpr unsigned all = 0x100; // of all drives, since the request may have been to any
    const auto send = [&] {
        while (x.is_to_leave()) r.on.step(x, r.gaps);
    };
    SUBCASE("no response, or a damaged one") {
        r.port.device = {};
        SUBCASE("none") {}
        SUBCASE("damaged") { r.port.say_at(r.port.time + 5000, byte_list(7, 0x01)); }
        r.finish(x);
    }
    SUBCASE("it is truncated while it leaves") {
        r.port.never_sent = true;
        r.on.run(x, r.gaps);
        CHECK(x.status().error() == errc::partial_send);
    }
    SUBCASE("it is abandoned while it leaves") {
        while (x.state() != exchange::phase::leaving) r.on.step(x, r.gaps);
        r.on.abandon(x);
    }
    SUBCASE("it is abandoned after that") {
        send();
        r.on.abandon(x);
    }
    SUBCASE("its owner stops stepping it, and returns") {
        send();
        r.port.time += 2 * r.bound();
        CHECK(r.on.is_free());
        bus_gaps = all;
        r.on.step(x, r.gaps);
    }
    SUBCASE("its owner stops stepping it while it leaves") {
        while (x.state() != exchange::phase::leaving) r.on.step(x, r.gaps);
        r.port.time += 2 * r.bound();
        bus_gaps = all;
    }
    SUBCASE("but a response does not, nor does an exception") {
        bus_gaps = 0;
        SUBCASE("a response") {}
        SUBCASE("an exception") {
            r.port.device = [](scripted_port& p, const auto&) {
                p.say(500, tests::exception_response(1, 3, 2));
            };
        }
        r.finish(x);
    }
    SUBCASE("nor does a request that never left") {
        bus_gaps = 0;
        SUBCASE("the line is never free") {
            r.port.noisy_until = r.port.time + 10'000'000;
            r.on.run(x, r.gaps);
            CHECK(x.status().error() == errc::line_busy);
        }
        SUBCASE("it is abandoned before, or not stepped any more") {
            r.on.step(x, r.gaps);
            REQUIRE_FALSE(r.on.is_sending());
            SUBCASE("abandoned") { r.on.abandon(x); }
            SUBCASE("not stepped") { r.port.time += 2 * r.bound(); }
        }
    }
    SUBCASE("nor does a broadcast, whole or truncated") {
        bus_gaps = 0;
        x = r.make(stop_all, 0);
        SUBCASE("whole") {}
        SUBCASE("truncated") { r.port.never_sent = true; }
        r.on.run(x, r.gaps);
        CHECK(x.was_sent());
    }
    CHECK(r.on.is_free());
    CHECK(r.on.epoch(1).misses == before + bus_gaps);
    CHECK(r.on.epoch(2).misses == other + (bus_gaps == all ? all : 0));
}

TEST_CASE("G21: no epoch comes back after 65535 misses of one node, or of all") {
    rig r;
    const servobus::epoch first = r.on.epoch(1);
    for (int misses = 1; misses <= 0xFFFF; ++misses) {
        r.on.begin_epoch(1);
        REQUIRE(r.on.epoch(1) != first);
    }
    const servobus::epoch second = r.on.epoch(1);
    for (int misses = 1; misses <= 0xFFFF; ++misses) {
        r.on.begin_epoch(0);
        REQUIRE(r.on.epoch(1) != second);
    }
}

TEST_CASE("G21: a lost port invalidates the state of all drives, and no number of timeouts makes an old "
          "count valid again") {
    rig r;
    r.settle();
    std::array<std::uint16_t, 8> before{};
    for (std::uint8_t node_address = 1; node_address <= 8; ++node_address)
        before[node_address - 1u] = r.on.epoch(node_address).misses;
    SUBCASE("a port that is lost before anything has left") {
        r.port.lost_from_call = 1;
        exchange x = r.make(read_one, 0);
        r.on.run(x, r.gaps);
        for (std::uint8_t node_address = 1; node_address <= 8; ++node_address)
            CHECK(r.on.epoch(node_address).misses != before[node_address - 1u]);
    }
    SUBCASE("a thousand timeouts") {
        r.port.device = {};
        r.limits = {.response = milliseconds(1)};
        for (int i = 0; i < 1000; ++i) {
            exchange x = r.make(read_one, 0);
            r.on.run(x, {});
            REQUIRE(r.on.epoch(1).misses != before[0]);
        }
    }
}

TEST_CASE("a broadcast that is not stepped any more holds the line for its own time only") {
    rig r;
    r.limits.turnaround = milliseconds(10);
    r.limits.response = milliseconds(5000); // would be that of a response
    r.settle();
    exchange forgotten = r.make(stop_all, 0);
    while (forgotten.is_to_leave()) r.on.step(forgotten, r.gaps);
    CHECK_FALSE(r.on.is_free());
    r.port.time += 1'000'000;
    CHECK(r.on.is_free());
}

TEST_CASE("a request that is abandoned while it leaves counts as sent, and its rest is not sent") {
    for (std::uint32_t taken = 0; taken < 8; ++taken) {
        CAPTURE(taken);
        rig r;
        r.settle();
        r.port.takes_at_most = 1;
        exchange x = r.make(write_one, 0);
        while (r.port.bytes_sent() < taken) r.on.step(x, r.gaps);
        CHECK(x.state() == (taken == 0 ? exchange::phase::ready : exchange::phase::leaving));
        CHECK(r.on.is_sending() == (taken != 0));
        r.on.abandon(x);
        CHECK(x.done());
        CHECK(x.was_sent() == (taken != 0));
        CHECK(x.status().error() == (taken != 0 ? errc::timeout : errc::busy));
        CHECK_FALSE(r.on.is_sending());
        CHECK(r.on.is_free());
        r.on.abandon(x); // a second time: no effect
        CHECK(x.was_sent() == (taken != 0));
        const std::uint64_t over = r.port.time;
        r.port.takes_at_most = 1000;
        exchange next = r.make(read_one, 1);
        r.finish(next);
        CHECK(next.status() == errc::ok);
        CHECK(r.port.frames.back().data == read_one);
        CHECK((r.port.frames.back().begin >= over + 100'000 - 20) == (taken != 0));
        CHECK(r.port.bytes_sent() == taken + read_one.size());
    }
}

TEST_CASE("G2: the response to an abandoned request is dropped, however late it arrives") {
    for (const bool leaves_slowly : {false, true}) { // the port has it all, and most of it still has to leave
        for (const std::uint32_t response_after : {500u, 60'000u, 99'000u, 119'000u}) {
            CAPTURE(leaves_slowly);
            CAPTURE(response_after);
            rig r;
            r.gaps.quarantine = milliseconds(20);
            r.port.character_us = leaves_slowly ? 9167 : 96;
            line<scripted_port> on{r.port, modbus::timing_at(leaves_slowly ? 1200 : 115200)};
            unsigned asked = 0;
            r.port.device = [&](scripted_port& p, const tests::sent_frame&) {
                if (asked++ == 0) return p.say(response_after, tests::read_response(1, {0x1111}));
                p.say(500, one_word);
            };
            exchange x{read_one, r.room[0], on.timing(), r.limits};
            while (!on.is_sending()) on.step(x, r.gaps);
            if (!leaves_slowly) {
                while (x.is_to_leave()) on.step(x, r.gaps);
            }
            on.abandon(x);
            exchange next{read_one, r.room[1], on.timing(), r.limits};
            while (!next.done()) on.step(next, r.gaps);
            CHECK(next.status() == errc::ok);
            CHECK(next.words()[0] == 0x0960);
            CHECK(asked == 2);
        }
    }
}

TEST_CASE("an exchange that has ended keeps its result when it is abandoned") {
    rig r;
    exchange x = r.make(read_one, 0);
    r.finish(x);
    REQUIRE(x.status() == errc::ok);
    const std::uint32_t ended = r.on.observer().responses;
    r.on.abandon(x);
    CHECK(x.status() == errc::ok);
    CHECK(r.on.step(x, r.gaps) == duration{});
    CHECK(r.on.observer().responses == ended);
    CHECK(r.on.observer().timeouts == 0);
    exchange next = r.make(read_one, 1);
    const std::uint64_t heard = r.port.last_heard;
    r.finish(next);
    CHECK(r.port.frames.back().begin < heard + 1750 + 40); // no quarantine
}

TEST_CASE("G1: a new line is free, reads no clock, and its first quarantine counts from the first request") {
    scripted_port port;
    port.time = 0;
    port.call_us = 0; // the first reading of the clock is 0 too
    line<scripted_port> first{port, modbus::timing_at(115200)};
    CHECK(first.is_free());
    rig r;
    r.port.time += 200'000;
    const std::uint64_t asked = r.port.time;
    exchange x = r.make(read_one, 0);
    r.finish(x);
    CHECK(r.port.frames[0].begin >= asked + r.gaps.quarantine.us);
    CHECK(r.port.frames[0].begin <= asked + r.gaps.quarantine.us + 60);
}

TEST_CASE("G1, G8: while the port was lost nothing was received: the gap counts from its return") {
    for (const std::uint32_t away_ms : {0u, 5u, 500u, 100'000u}) {
        CAPTURE(away_ms);
        rig r;
        r.settle();
        for (std::uint32_t tries = 0; tries < 3; ++tries) {
            r.port.lost_from_call = r.port.calls + 1;
            exchange x = r.make(read_one, 0);
            r.finish(x);
            CHECK(x.status() == errc::port_lost);
            r.port.time += away_ms * 1000;
        }
        r.port.lost_from_call = 0;
        const std::uint64_t back = r.port.time;
        exchange x = r.make(read_one, 0);
        r.finish(x);
        CHECK(x.status() == errc::ok);
        CHECK(r.port.frames.back().begin - back >= r.gaps.quarantine.us);
        CHECK(r.port.frames.back().begin - back <= r.gaps.quarantine.us + 100);
        // Only once: after that a quiet line counts again.
        r.port.time += 50'000;
        const std::uint64_t again = r.port.time;
        exchange y = r.make(read_one, 1);
        r.finish(y);
        CHECK(r.port.frames.back().begin - again <= 100);
    }
}

TEST_CASE("tickets continue through their wrap, and none is zero") {
    detail::arbiter arbiter;
    CHECK_FALSE(arbiter.is_held());
    CHECK_FALSE(arbiter.is_held_by(0));
    CHECK_FALSE(arbiter.is_held_by(1));
    CHECK_FALSE(arbiter.has_stop());
    std::uint16_t last = arbiter.new_ticket();
    for (unsigned i = 0; i < 70'000; ++i) {
        const std::uint16_t ticket = arbiter.new_ticket();
        REQUIRE(ticket != 0);
        REQUIRE(ticket != last);
        REQUIRE(arbiter.take(ticket, false, false, {}));
        REQUIRE(arbiter.is_held_by(ticket));
        REQUIRE_FALSE(arbiter.is_held_by(last));
        arbiter.release();
        REQUIRE_FALSE(arbiter.is_held());
        last = ticket;
    }
}

TEST_CASE(
    "G1, G2: a clock that jumps back while a response is awaited does not shorten the quarantine after it") {
    // When the response really arrives: within its time limit, or within the quarantine after that.
    for (const std::uint32_t response_after : {60'000u, 101'000u, 150'000u, 198'000u}) {
        for (const std::uint32_t jump : {1u, 500u, 3'000u, 90'000u, 2'000'000u}) {
            for (const std::uint64_t jump_after :
                 {0u, 200u, 900u, 5'000u, 80'000u}) { // since the port took the request
                for (const bool is_forgotten : {false, true}) {
                    CAPTURE(response_after);
                    CAPTURE(jump);
                    CAPTURE(jump_after);
                    CAPTURE(is_forgotten);
                    rig r;
                    r.settle();
                    unsigned asked = 0;
                    r.port.device = [&](scripted_port& p, const tests::sent_frame&) {
                        if (asked++ == 0) return p.say(response_after, tests::read_response(1, {0x1111}));
                        p.say(90'000, one_word);
                    };
                    exchange x = r.make(read_one, 0);
                    while (r.port.frames.empty()) r.on.step(x, r.gaps);
                    const std::uint64_t at = r.port.time + jump_after;
                    r.port.clock = [=](std::uint64_t t) {
                        return static_cast<std::uint32_t>(t < at ? t : t - jump);
                    };
                    while (!x.done() && !(is_forgotten && r.port.time > at)) r.on.step(x, r.gaps);
                    // The drive is asked for another register, with a response of the same length.
                    exchange next = r.make(framed({0x01, 0x03, 0x20, 0xAB, 0x00, 0x01}), 1);
                    r.finish(next);
                    if (next.status() == errc::ok) CHECK(next.words()[0] == 0x0960);
                    if (x.done() && x.status() == errc::ok) CHECK(x.words()[0] == 0x1111);
                }
            }
        }
    }
}

TEST_CASE("G29: eight jumps back are accepted from a clock, the ninth is not") {
    detail::stall_detector guard{{1'000'000}, 100};
    instant now{1'000'000};
    for (int i = 0; i < 8; ++i) {
        now = instant{now.us - 1000};
        CHECK_FALSE(guard.has_failed(now));
        CHECK_FALSE(guard.has_failed(now + microseconds(10)));
    }
    CHECK(guard.has_failed(instant{now.us - 1000}));
}

TEST_CASE("G29: a clock counts as stopped after a number of equal readings, and not while it moves") {
    detail::stall_detector guard{{5}, 100};
    for (int i = 0; i < 100; ++i) CHECK_FALSE(guard.has_failed({5}));
    CHECK_FALSE(guard.has_failed({6}));
    for (int i = 0; i < 100; ++i) CHECK_FALSE(guard.has_failed({6}));
    CHECK(guard.has_failed({6}));
}

TEST_CASE("G4: the echo of a long request is removed whole, however slow the program's loop is") {
    byte_list request{0x01, 0x10, 0x01, 0x00, 0x00, 30, 60};
    for (std::uint8_t i = 0; i < 60; ++i) request.push_back(i);
    request = framed(request);
    for (const std::uint32_t turn_ms : {0u, 9u, 20u, 45u}) {
        CAPTURE(turn_ms);
        scripted_port port;
        port.echoes = port.keeps_echo = true;
        port.device = [](scripted_port& p, const tests::sent_frame& f) {
            p.say(500, tests::acknowledgement(f.data));
        };
        line<scripted_port, counters, echoed> on{port, modbus::timing_at(115200)};
        const response_limits limits{.response = milliseconds(500)};
        std::array<std::uint8_t, 8> room{};
        exchange x{request, room, on.timing(), limits};
        while (!x.done()) {
            (void)on.step(x, bus_gaps{{}, milliseconds(100)});
            port.time += turn_ms * 1000u;
        }
        CHECK(x.status() == errc::ok);
    }
}

} // namespace line_faults_tests
