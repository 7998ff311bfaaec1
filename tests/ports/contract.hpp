// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The contract of line/port.hpp as checks that every port must pass over its fake. A rig makes the port and
// starts it on a new wire:
//
//     auto& port();
//     static constexpr bool tells_errors;      // a damaged character is `receive_failed`
//     static constexpr bool drives_by_itself;  // the driver switches off even if `sent()` is not called
//     void refuse_next();                      // the vendor's send fails once; only if `can_refuse`
//     static constexpr bool can_refuse;
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/client/client.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/registers/reg.hpp>

#include "wire.hpp"

namespace contract {

struct device {
    static constexpr servobus::profile facts{.name = "node"};
};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, device> level{
    0x0010, servobus::full<servobus::u16>, servobus::no_unit, 0};

/// Responds to a read with the address as the value, and to a write with its echo.
inline fake::frame answer(const fake::frame& request) {
    if (request.size() != 8) return {};
    fake::frame response(8);
    if (request[1] == 3) {
        response = {request[0], 3, 2, request[2], request[3], 0, 0};
        (void)servobus::modbus::close_frame(response, 4);
    } else {
        response = request;
    }
    return response;
}

inline const fake::frame request = {1, 6, 0x20, 0x0E, 0, 8, 0xE2, 0x0F};

/// Offers a frame until it is taken, then waits until it has left. Overwrites the bytes that the port has
/// taken.
template <class Port> void send_whole(Port& port, fake::frame bytes) {
    std::size_t taken = 0;
    for (int looks = 0; taken < bytes.size() && looks < 100'000; ++looks) {
        const auto t = port.send(servobus::bytes{bytes}.subspan(taken));
        REQUIRE(t);
        for (std::size_t i = 0; i < *t; ++i) bytes[taken + i] = 0xEE;
        taken += *t;
        (void)port.now();
    }
    REQUIRE(taken == bytes.size());
    CHECK_FALSE(port.sent());
    for (int looks = 0; looks < 100'000 && !port.sent(); ++looks) (void)port.now();
    REQUIRE(port.sent());
}

template <class Rig> void frames_leave_whole(std::size_t size) {
    fake::line() = {};
    Rig rig;
    fake::frame bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + 1);
    for (int turn = 0; turn < 2; ++turn) {
        fake::line().left.clear();
        send_whole(rig.port(), bytes);
        CHECK(fake::line().now >= fake::line().free_at);
        CHECK(fake::line().left == bytes);
        CHECK(fake::line().torn == 0);
        CHECK(fake::line().longest_pause <= 750);
        CHECK_FALSE(fake::line().driver);
        CHECK(fake::line().driver_off_at >= fake::line().free_at);
        CHECK(fake::line().driver_off_at < fake::line().free_at + fake::wire::t3_5);
        fake::line().advance(10'000);
    }
}

/// A loop that is late loses no byte, and the driver is switched off in time.
template <class Rig> void late_loop() {
    fake::line() = {};
    Rig rig;
    fake::line().node = answer;
    REQUIRE(*rig.port().send(request) == request.size());
    fake::line().advance(20'000);
    CHECK_FALSE(fake::line().driver);
    CHECK(fake::line().driver_off_at < fake::line().free_at + fake::wire::t3_5);
    for (int looks = 0; looks < 10 && !rig.port().sent(); ++looks) (void)rig.port().now();
    REQUIRE(rig.port().sent());
    std::array<std::uint8_t, 32> in{};
    const auto came = rig.port().receive(in);
    REQUIRE(came);
    CHECK(fake::frame(in.begin(), in.begin() + *came) == request);
}

template <class Rig> void partial_reads() {
    fake::line() = {};
    Rig rig;
    send_whole(rig.port(), request);
    std::array<std::uint8_t, 4> in{};
    CHECK(*rig.port().receive(in) == 0);
    fake::line().arrive({1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
    fake::line().advance(20'000);
    fake::frame got;
    for (const std::size_t expected : {4u, 4u, 2u, 0u}) {
        const auto came = rig.port().receive(in);
        REQUIRE(came);
        CHECK(*came == expected);
        got.insert(got.end(), in.begin(), in.begin() + *came);
    }
    CHECK(got == fake::frame{1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
    fake::line().arrive({11});
    fake::line().advance(20'000);
    CHECK(*rig.port().receive(in) == 1);
    CHECK(in[0] == 11);
}

/// A line and a client over the port.
template <class Rig> struct station {
    using line = servobus::line<typename Rig::port_type>;

    station() { fake::line().node = answer; }
    static bool reset() {
        fake::line() = {};
        return true;
    }
    void check_works() {
        const auto seen = client.template read<level>();
        CHECK(seen);
        CHECK(*seen == 0x0010);
        CHECK(fake::line().requests.size() >= 1);
        CHECK(fake::line().requests.back().size() == 8);
        CHECK_FALSE(fake::line().driver);
    }

    bool is_reset = reset(); // before the port is constructed
    Rig rig;
    line wire{rig.port(), servobus::modbus::timing_at(115200)};
    servobus::client<line, device> client{wire, servobus::node<device>{1}};
};

template <class Rig> void transactions() {
    station<Rig> s;
    for (int i = 0; i < 3; ++i) s.check_works();
    CHECK(s.client.template write<level>(7));
    CHECK(fake::line().collisions == 0);
    CHECK(fake::line().torn == 0);
    CHECK(s.wire.observer().responses == 4);
    CHECK(s.wire.observer().unexpected_bytes == 0);
}

template <class Rig> void early_bytes_and_echo() {
    station<Rig> s;
    fake::line().arrive({1, 3, 2, 9, 9});
    fake::line().advance(20'000);
    s.check_works();
    CHECK(s.wire.observer().unexpected_bytes == 5);
    fake::line().has_echo = true;
    s.check_works();
    s.check_works();
    CHECK(s.wire.observer().unexpected_bytes == 5);
}

/// The node has no power, and a loop that is late finds the echo of its request only.
template <class Rig> void late_echo() {
    station<Rig> s;
    fake::line().has_echo = true;
    s.check_works();
    s.check_works();
    fake::line().node = nullptr;
    auto& port = s.rig.port();
    REQUIRE(*port.send(request) == request.size());
    fake::line().advance(20'000);
    for (int looks = 0; looks < 10 && !port.sent(); ++looks) (void)port.now();
    REQUIRE(port.sent());
    std::array<std::uint8_t, 32> in{};
    CHECK(*port.receive(in) == 0);
}

/// Two calls of a main loop that never waits.
template <class Rig> void stepped_calls() {
    station<Rig> s;
    using client = decltype(s.client);
    servobus::stepped_read<client, level> seen{s.client};
    servobus::stepped_write<client, level> written{s.client};
    CHECK(seen.begin() == servobus::errc::ok);
    CHECK(written.begin(7) == servobus::errc::ok);
    for (int i = 0; i < 100'000 && !(seen.done() && written.done()); ++i) {
        (void)seen.step();
        (void)written.step();
        fake::line().advance(20);
    }
    CHECK(seen.value());
    CHECK(*seen.value() == 0x0010);
    CHECK(written.status());
    CHECK(fake::line().requests.size() == 2);
    CHECK(fake::line().collisions == 0);
    CHECK(fake::line().torn == 0);
    CHECK_FALSE(fake::line().driver);
}

template <class Rig> void no_answer() {
    station<Rig> s;
    fake::line().node = nullptr;
    CHECK(s.client.template read<level>().error() == servobus::errc::timeout);
    CHECK_FALSE(fake::line().driver);
    fake::line().node = answer;
    s.check_works();
}

/// A damaged character of a response ends the call, once, and the next call works.
template <class Rig> void damaged_responses() {
    for (const fake::damage how : {fake::damage::framing, fake::damage::overrun}) {
        for (const std::size_t where : {0u, 3u, 6u}) {
            CAPTURE(where);
            station<Rig> s;
            s.client.node().read_retries = 0;
            s.check_works();
            fake::line().how = how;
            fake::line().damaged = where;
            const auto seen = s.client.template read<level>();
            if constexpr (Rig::tells_errors)
                CHECK(seen.error() == servobus::errc::receive_failed);
            else
                CHECK_FALSE(seen);
            fake::line().damaged = SIZE_MAX;
            fake::line().advance(50'000);
            s.check_works();
        }
    }
}

/// Many more bytes than any buffer holds.
template <class Rig> void flood() {
    station<Rig> s;
    fake::line().arrive(fake::frame(2000, 0x55));
    fake::line().advance(2000 * fake::wire::character + 20'000);
    std::array<std::uint8_t, 32> in{};
    unsigned failures = 0;
    for (int looks = 0; looks < 200; ++looks) {
        const auto came = s.rig.port().receive(in);
        if (!came) ++failures;
        (void)s.rig.port().now();
    }
    CHECK(failures == (Rig::tells_errors ? 1 : 0));
    s.check_works();
}

template <class Rig> void refused_send() {
    station<Rig> s;
    s.rig.refuse_next();
    const auto written = s.client.template write<level>(7);
    CHECK(written.error() == servobus::errc::send_failed);
    CHECK(written.outcome() == servobus::outcome::not_sent);
    CHECK_FALSE(fake::line().driver);
    s.check_works();
}

/// A clock that mishandles its wrap would jump by seconds or stop.
template <class Rig> void clock_wraps() {
    fake::line() = {};
    Rig rig;
    const auto before = rig.port().now();
    fake::line().advance(42'000);
    const auto passed = servobus::since(before, rig.port().now()).us;
    CHECK(passed >= 41'000);
    CHECK(passed <= 43'100);
}

/// `wait` ends with the first byte or after its time.
template <class Rig> void wakes() {
    fake::line() = {};
    Rig rig;
    send_whole(rig.port(), request);
    fake::line().advance(5'000);
    std::array<std::uint8_t, 4> in{};
    CHECK(*rig.port().receive(in) == 0);
    rig.port().wait(servobus::milliseconds(1)); // an earlier event may end it
    std::uint64_t start = fake::line().now;
    rig.port().wait(servobus::milliseconds(5));
    CHECK(fake::line().now - start <= 5'000);
    CHECK(fake::line().now - start >= 4'000);
    start = fake::line().now;
    fake::line().arrive({1});
    rig.port().wait(servobus::milliseconds(5));
    CHECK(fake::line().now - start < 1'000);
    CHECK(*rig.port().receive(in) == 1);
    rig.port().wait(servobus::microseconds(200)); // less than a tick: it may return immediately
}

template <class Rig> void all() {
    SUBCASE("G31: a frame leaves complete, with the driver on from its first to its last bit") {
        frames_leave_whole<Rig>(8);
    }
    SUBCASE("G31: a frame of one byte leaves complete, with the driver on") { frames_leave_whole<Rig>(1); }
    SUBCASE("G31: the longest frame leaves complete, with the driver on") { frames_leave_whole<Rig>(256); }
    SUBCASE("a read continues where the last one ended") { partial_reads<Rig>(); }
    SUBCASE("the transactions of a client succeed") { transactions<Rig>(); }
    SUBCASE("stepped calls succeed") { stepped_calls<Rig>(); }
    SUBCASE("early bytes and echoes are not taken for a response") { early_bytes_and_echo<Rig>(); }
    SUBCASE("G3: an echo that a late loop finds is not taken for a response") { late_echo<Rig>(); }
    SUBCASE("no response is a timeout") { no_answer<Rig>(); }
    SUBCASE("a damaged response is an error and does not block") { damaged_responses<Rig>(); }
    SUBCASE("after more bytes than the buffers hold the port works") { flood<Rig>(); }
    SUBCASE("the clock wraps correctly") { clock_wraps<Rig>(); }
    if constexpr (Rig::drives_by_itself) {
        SUBCASE("G31: a late loop loses no byte, and the driver is switched off in time") {
            late_loop<Rig>();
        }
    }
    if constexpr (Rig::can_refuse) {
        SUBCASE("a refused send is an error, and the driver is off") { refused_send<Rig>(); }
    }
    if constexpr (servobus::waiting_port<typename Rig::port_type>) {
        SUBCASE("wait ends with a byte or after its time") { wakes<Rig>(); }
    }
}

} // namespace contract
