// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which exchange may use a line: one at a time, a stop before all that have not begun to leave.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>

namespace arbiter_tests {

using namespace servobus;
using detail::arbiter;

namespace {
// The request of the exchange that has the line has begun to leave, or not.
constexpr bool has_left = true;
constexpr bool waits = false;
} // namespace

TEST_CASE("G25: a stop that keeps requesting the line is next, however long the frame in progress takes") {
    arbiter t;
    const std::uint16_t read = t.new_ticket(), stop = t.new_ticket(), other = t.new_ticket();
    REQUIRE(t.take(read, false, waits, {0}));
    for (std::uint32_t ms = 0; ms <= 2000; ms += 100) {
        CHECK_FALSE(t.take(stop, true, has_left, {ms * 1000}));
        CHECK(t.has_stop());
        CHECK_FALSE(t.take(other, false, has_left, {ms * 1000 + 1}));
    }
    t.release();
    CHECK_FALSE(t.take(other, false, waits, {2'400'000}));
    CHECK_FALSE(t.take(other, true, waits, {2'400'000})); // another stop, which came later
    CHECK(t.take(stop, true, waits, {2'400'000}));
    CHECK_FALSE(t.has_stop());
}

TEST_CASE("G25: a stop that is requested no longer loses its place to a second one that keeps requesting") {
    arbiter t;
    const std::uint16_t read = t.new_ticket(), stop = t.new_ticket(), other = t.new_ticket();
    REQUIRE(t.take(read, false, waits, {0}));
    CHECK_FALSE(t.take(stop, true, has_left, {0}));
    for (std::uint32_t ms = 100; ms <= 500; ms += 100)
        CHECK_FALSE(t.take(other, true, has_left, {ms * 1000}));
    t.release();
    CHECK_FALSE(t.take(other, true, waits, {500'000}));
    CHECK(t.take(other, true, waits, {500'001})); // the first one has not been requested since
}

TEST_CASE("G25: a stop that is announced has the next place, whichever asks first") {
    arbiter t;
    const std::uint16_t read = t.new_ticket(), stop = t.new_ticket(), other = t.new_ticket();
    REQUIRE(t.take(read, false, waits, {0})); // it has not begun to leave
    t.announce_stop(waits, {1});
    CHECK(t.has_stop());
    CHECK_FALSE(t.is_held_by(read));
    CHECK_FALSE(t.take(read, false, waits, {2}));
    CHECK_FALSE(t.take(other, false, waits, {3}));
    CHECK(t.take(stop, true, waits, {4}));
    t.announce_stop(has_left, {5}); // another drive's, while the first is on the wire
    CHECK(t.is_held_by(stop));
    t.release();
    CHECK_FALSE(t.take(read, false, waits, {6}));
    CHECK(t.take(other, true, waits, {7}));
    t.release();
    CHECK(t.take(read, false, waits, {8}));
    t.release();
    // It never asks: after half a second its place is free.
    t.announce_stop(waits, {10});
    CHECK_FALSE(t.take(read, false, waits, {500'010}));
    CHECK(t.take(read, false, waits, {500'011}));
}

TEST_CASE("a ticket is never that of an announced stop, nor that of no exchange") {
    arbiter t;
    for (std::uint32_t i = 0; i < 70'000; ++i) {
        const std::uint16_t ticket = t.new_ticket();
        REQUIRE(ticket != 0);
        REQUIRE(ticket != 0xFFFF);
    }
}

TEST_CASE("a stop takes the place of what has not left, and of no other stop") {
    arbiter t;
    const std::uint16_t read = t.new_ticket(), stop = t.new_ticket(), other = t.new_ticket();
    REQUIRE(t.take(read, false, waits, {0}));
    CHECK(t.take(stop, true, waits, {1}));
    CHECK_FALSE(t.is_held_by(read));
    CHECK_FALSE(t.take(other, true, waits, {2}));
    t.release();
    CHECK(t.take(other, true, waits, {3}));
    t.release();
    REQUIRE(t.take(read, false, waits, {4})); // after a stop a read has no stop priority
    CHECK(t.take(stop, true, waits, {5}));
}

TEST_CASE("an exchange that is abandoned before it left frees the line for the next one immediately") {
    tests::scripted_port port;
    line<tests::scripted_port> wire{port, modbus::timing_at(115200)};
    const response_limits limits{};
    std::array<std::uint8_t, 7> room{};
    std::array<std::uint8_t, 7> other_room{};
    const modbus::frame<8> request = modbus::read_frame(1, 0x2000, 1);
    modbus::exchange given_up{request, room, wire.timing(), limits};
    (void)wire.step(given_up, bus_gaps{});
    REQUIRE_FALSE(wire.is_free());
    wire.abandon(given_up);
    CHECK(given_up.status() == errc::busy);
    CHECK_FALSE(given_up.was_sent());
    CHECK(wire.is_free());
    port.device = [](tests::scripted_port& p, const tests::sent_frame&) {
        p.say(500, tests::read_response(1, {9}));
    };
    modbus::exchange next{request, other_room, wire.timing(), limits};
    wire.run(next, bus_gaps{});
    CHECK(next.status() == errc::ok);
    CHECK(port.frames.size() == 1);
}

TEST_CASE(
    "G25: a stop that is abandoned while it waits for the frame in flight keeps its place free no longer") {
    tests::scripted_port port;
    line<tests::scripted_port> wire{port, modbus::timing_at(115200)};
    const response_limits limits{};
    std::array<std::uint8_t, 7> room{};
    std::array<std::uint8_t, 7> room_of_stop{};
    const modbus::frame<8> request = modbus::read_frame(1, 0x2000, 1);
    port.device = [](tests::scripted_port& p, const tests::sent_frame&) {
        p.say(500, tests::read_response(1, {9}));
    };
    modbus::exchange first{request, room, wire.timing(), limits};
    while (!first.was_sent()) {
        (void)wire.step(first, bus_gaps{});
        port.time += 100;
    }
    modbus::exchange stop{request, room_of_stop, wire.timing(), limits, priority::stop};
    (void)wire.step(stop, bus_gaps{});
    wire.abandon(stop);
    CHECK_FALSE(stop.was_sent());
    wire.run(first, bus_gaps{});
    CHECK(first.status() == errc::ok);
    CHECK(wire.is_free());
}

} // namespace arbiter_tests
