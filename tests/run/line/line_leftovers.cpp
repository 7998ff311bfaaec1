// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What an exchange that ended early leaves on the line: the rest of its request, its late response, the loss
// of its port. None of them may disturb the next exchange.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <servobus/line/line.hpp>

#include <tests/support/scripted_port.hpp>

namespace line_leftovers_tests {

using namespace servobus;
using modbus::exchange;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;

namespace {

const byte_list read_one = framed({0x01, 0x03, 0x20, 0xA1, 0x00, 0x01});
const byte_list read_other = framed({0x01, 0x03, 0x20, 0xAB, 0x00, 0x01});
const byte_list stop = framed({0x01, 0x06, 0x20, 0x0E, 0x00, 0x07});
const byte_list late_words = tests::read_response(1, {0x1111});
const byte_list own_words = tests::read_response(1, {0x0960});

/// Calls a function just before each call of `send`, and of `sent`.
struct interrupted_port : scripted_port {
    std::function<void(interrupted_port&)> before_send;
    std::function<void(interrupted_port&)> before_sent;

    servobus::transfer send(servobus::bytes out) {
        if (before_send) before_send(*this);
        return scripted_port::send(out);
    }
    bool sent() {
        if (before_sent) before_sent(*this);
        return scripted_port::sent();
    }
};

struct rig {
    interrupted_port port;
    response_limits limits;
    bus_gaps gaps{{}, milliseconds(20)};
    line<interrupted_port> on{port, modbus::timing_at(115200)};
    std::array<std::array<std::uint8_t, 16>, 3> room{};
    unsigned asked = 0;

    rig() {
        settle();
        port.device = {};
    }
    rig(const rig&) = delete;
    void settle() {
        port.device = [](scripted_port& p, const tests::sent_frame&) { p.say(500, own_words); };
        exchange x = make(read_one, 2);
        finish(x);
        REQUIRE(x.status() == errc::ok);
        port.frames.clear();
    }
    /// The first request gets its response after `us`, the others in time.
    void answer_first_after(std::uint32_t us) {
        port.device = [this, us](scripted_port& p, const tests::sent_frame&) {
            if (asked++ == 0) return p.say(us, late_words);
            p.say(90'000, own_words);
        };
    }
    exchange make(const byte_list& request, std::size_t which) {
        return {request, room[which], on.timing(), limits};
    }
    void finish(exchange& x) {
        while (!x.done()) on.step(x, gaps);
    }
};

} // namespace

TEST_CASE("G2: a response that arrives after its exchange ended with a garbled character is dropped") {
    for (const std::uint32_t response_after : {30'000u, 60'000u, 99'000u, 118'000u}) {
        for (const std::uint64_t garbled_after : {1u, 5'000u, 20'000u}) {
            CAPTURE(response_after);
            CAPTURE(garbled_after);
            rig r;
            r.answer_first_after(response_after);
            exchange x = r.make(read_one, 0);
            while (x.state() != exchange::phase::awaiting) r.on.step(x, r.gaps);
            r.port.time += garbled_after;
            r.port.noisy_until = r.port.time + 10;
            r.finish(x);
            REQUIRE(x.status() == errc::receive_failed);
            exchange next = r.make(read_other, 1);
            r.finish(next);
            REQUIRE(next.status() == errc::ok);
            CHECK(next.words()[0] == 0x0960);
        }
    }
}

TEST_CASE("G1: nothing follows a truncated request until what the port has of it has left") {
    for (const unsigned way : {0u, 1u, 2u, 3u}) {
        const bool is_stop = (way & 1u) != 0;
        const bool is_stopped = (way & 2u) != 0;
        for (const std::size_t taken : {1u, 4u, 7u, 8u}) {
            CAPTURE(is_stop);
            CAPTURE(is_stopped);
            CAPTURE(taken);
            rig r;
            r.port.character_us = 9'167;
            r.port.takes_at_most = taken;
            r.port.device = {};
            line<interrupted_port> slow{r.port, modbus::timing_at(1200)};
            exchange x{read_one, r.room[0], slow.timing(), r.limits};
            while (r.port.bytes_sent() == 0) slow.step(x, r.gaps);
            slow.abandon(x);
            const std::uint64_t rest_leaves = r.port.frames.back().end;
            REQUIRE(rest_leaves > r.port.time + 9'000);
            r.port.takes_at_most = 1000;
            const priority how = is_stop ? priority::stop : priority::ordinary;
            exchange next{stop, r.room[1], slow.timing(), r.limits, how};
            // The program is stopped, once, until the rest has left.
            if (is_stopped)
                r.port.before_sent = [=](interrupted_port& p) { p.time = std::max(p.time, rest_leaves); };
            while (r.port.bytes_sent() == taken && !next.done()) slow.step(next, r.gaps);
            REQUIRE(r.port.bytes_sent() == taken + stop.size());
            const std::uint64_t begun = r.port.frames.back().end - 8u * 9'167u;
            CHECK(begun >= rest_leaves + slow.timing().t3_5);
            if (is_stop) CHECK(begun <= rest_leaves + slow.timing().t3_5 + 9'167 + 100);
        }
    }
}

TEST_CASE("G1: bytes that arrived before the port took a request are no part of its response") {
    for (const std::size_t count : {1u, 31u, 32u, 33u, 200u}) {
        CAPTURE(count);
        rig r;
        r.port.character_us = 0; // it has left as soon as it was taken
        // They may be the beginning of another node's frame: a response counts after a gap.
        r.port.device = [](scripted_port& p, const tests::sent_frame&) { p.say(35'000, own_words); };
        bool is_late = true;
        r.port.before_send = [&](interrupted_port& p) {
            if (!is_late) return;
            is_late = false;
            p.time += 10'000; // the program stalls after it has emptied the receiver
            for (std::size_t i = late_words.size(); i < count; ++i) p.arrive(p.time, 0x00);
            for (const std::uint8_t b : late_words) p.arrive(p.time, b);
        };
        exchange x = r.make(read_one, 0);
        r.finish(x);
        REQUIRE(x.status() == errc::ok);
        CHECK(x.words()[0] == 0x0960);
    }
}

TEST_CASE("G1: the gap before a request is measured up to the time before the receiver was emptied") {
    for (const unsigned reading : {1u, 2u, 3u, 4u}) {
        for (const std::uint32_t before_the_end : {0u, 300u, 1'700u}) {
            CAPTURE(reading);
            CAPTURE(before_the_end);
            rig r;
            r.port.device = [](scripted_port& p, const tests::sent_frame&) { p.say(500, own_words); };
            exchange x = r.make(read_one, 0);
            r.on.step(x, r.gaps);
            REQUIRE(x.state() == exchange::phase::ready); // it waits for the gap
            // In one of the readings of its clock the program is stopped for 10 ms, and a byte arrives shortly
            // before the end.
            std::uint64_t byte_at = 0;
            unsigned readings = 0;
            r.port.clock = [&](std::uint64_t t) {
                if (++readings == reading) {
                    t = r.port.time += 10'000;
                    byte_at = t - before_the_end;
                    r.port.arrive(byte_at, 0x55);
                }
                return static_cast<std::uint32_t>(t);
            };
            r.finish(x);
            CHECK(x.status() == errc::ok);
            REQUIRE(byte_at != 0);
            CHECK(r.port.frames.back().begin >= byte_at + 1'750);
        }
    }
}

TEST_CASE("G21: a port that is lost while a request leaves is reported as lost") {
    for (const bool is_in_pieces : {false, true}) {
        CAPTURE(is_in_pieces);
        rig r;
        const std::uint8_t before = r.on.epoch(1).events.losses;
        if (is_in_pieces) r.port.takes_at_most = 3;
        exchange x = r.make(stop, 0);
        while (r.port.bytes_sent() == 0) r.on.step(x, r.gaps);
        r.port.lost_from_call = 1;
        r.finish(x);
        CHECK(x.status() == errc::port_lost);
        CHECK(x.status().outcome() == outcome::unknown);
        CHECK(static_cast<std::uint8_t>(r.on.epoch(1).events.losses - before) == 1);
    }
}

TEST_CASE("G21: a port that stays away counts as lost once, however often it is tried") {
    for (const unsigned tries : {1u, 2u, 255u, 256u, 512u}) {
        CAPTURE(tries);
        rig r;
        const std::uint8_t losses = r.on.epoch(1).events.losses;
        const std::uint16_t misses = r.on.epoch(1).misses;
        r.port.lost_from_call = 1;
        for (unsigned i = 0; i < tries; ++i) {
            exchange x = r.make(read_one, 0);
            r.finish(x);
            REQUIRE(x.status() == errc::port_lost);
        }
        CHECK(static_cast<std::uint8_t>(r.on.epoch(1).events.losses - losses) == 1);
        CHECK(r.on.epoch(1).misses != misses);
        // It returns, and is lost again: another loss.
        r.port.lost_from_call = 0;
        r.settle();
        r.port.lost_from_call = 1;
        exchange again = r.make(read_one, 0);
        r.finish(again);
        CHECK(static_cast<std::uint8_t>(r.on.epoch(1).events.losses - losses) == 2);
    }
}

TEST_CASE("a request that left while the program was stopped is not a truncated one") {
    rig r;
    bool is_armed = false;
    r.port.device = [](scripted_port& p, const tests::sent_frame&) { p.say(500, own_words); };
    r.port.clock = [&](std::uint64_t t) {
        if (is_armed) { // between the check that it has left and the reading of the clock
            is_armed = false;
            r.port.time += 3'000'000;
            return static_cast<std::uint32_t>(r.port.time);
        }
        return static_cast<std::uint32_t>(t);
    };
    exchange x = r.make(read_one, 0);
    while (x.is_to_leave() && !r.on.is_sending()) r.on.step(x, r.gaps);
    is_armed = true;
    r.finish(x);
    CHECK(x.was_sent());
    CHECK(x.status().error() != errc::partial_send);
    CHECK(r.port.frames.size() == 1);
}

namespace {

/// A port whose clock the test sets back; nothing responds. Notes when requests begin.
struct clock_port {
    std::uint64_t time = 1'000'000;
    std::uint32_t offset = 0;
    std::vector<std::uint64_t> begun{};

    transfer send(bytes out) {
        begun.push_back(time);
        return static_cast<std::uint16_t>(out.size());
    }
    static bool sent() { return true; }
    static transfer receive(byte_buffer) { return std::uint16_t{0}; }
    instant now() const { return instant{static_cast<std::uint32_t>(time) + offset}; }
};

struct silent_rig {
    clock_port port{};
    modbus::rtu_timing timing = modbus::timing_at(115200);
    line<clock_port> on{port, timing};
    response_limits limits{};
    std::array<std::uint8_t, 8> response{};

    /// Runs a request until it has ended. Returns when it began.
    std::uint64_t run(bytes request, const bus_gaps& gaps, const std::function<void()>& meanwhile = {}) {
        exchange x{request, response, timing, limits};
        const std::size_t before = port.begun.size();
        while (!x.done()) {
            (void)on.step(x, gaps);
            if (meanwhile && x.state() == exchange::phase::awaiting) meanwhile();
            port.time += 100;
        }
        REQUIRE(x.status().error() == errc::timeout);
        REQUIRE(port.begun.size() == before + 1);
        return port.begun.back();
    }
};

} // namespace

TEST_CASE("G2: a timeout that a clock which goes back has caused is early: the response may still come") {
    for (const bool goes_back : {false, true}) {
        CAPTURE(goes_back);
        silent_rig r;
        r.limits.response = milliseconds(200);
        const bus_gaps gaps{.quarantine = milliseconds(50)};
        const std::uint64_t first = r.run(read_one, gaps, [&r, goes_back] {
            if (goes_back && r.port.offset == 0) r.port.offset = 0u - 500'000u;
        });
        const std::uint64_t ended = r.port.time;
        CHECK((ended - first < 10'000) == goes_back);
        const std::uint64_t second = r.run(read_other, gaps);
        CHECK(second - first >= 250'000);
        CHECK(second - first < 270'000);
    }
}

} // namespace line_leftovers_tests
