// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line reports to its observer: which counter each end of a transaction raises, two observers
// together, and `unobserved`, which costs nothing.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/line/line.hpp>
#include <servobus/line/observer.hpp>

#include <tests/support/scripted_port.hpp>

namespace observer_tests {

using namespace servobus;
using tests::byte_list;

namespace {

struct tally {
    std::uint32_t requests = 0;
    std::uint32_t responses = 0;
    std::size_t stray = 0;
    status last{};
    void on_request(bytes) { ++requests; }
    void on_response(bytes, status why) {
        ++responses;
        last = why;
    }
    void on_unexpected(bytes b) { stray += b.size(); }
};

const byte_list request = tests::framed({1, 3, 0x20, 0xA1, 0, 1});

template <class Observer> result<std::uint16_t> ask(line<tests::scripted_port, Observer>& on) {
    std::array<std::uint8_t, 7> room{};
    const response_limits limits;
    modbus::exchange x{request, room, on.timing(), limits};
    on.run(x, {});
    if (x.status().error() != errc::ok) return x.status();
    return x.words()[0];
}

static_assert(observer<unobserved> && observer<counters> && observer<both<counters, tally>>);
static_assert(std::is_empty_v<unobserved>);
static_assert(sizeof(line<tests::scripted_port, unobserved>) < sizeof(line<tests::scripted_port, counters>));

} // namespace

TEST_CASE("each end of a transaction raises its own counter; an exception counts as a response and as an "
          "exception") {
    for (unsigned e = 0; e <= static_cast<unsigned>(errc::no_such_port); ++e) {
        const auto code = static_cast<errc>(e);
        CAPTURE(e);
        counters c;
        c.on_response({}, code);
        const bool is_transport = code == errc::send_failed || code == errc::partial_send ||
                                  code == errc::receive_failed || code == errc::port_lost ||
                                  code == errc::clock_stopped;
        const bool is_exception = code == errc::exception || code == errc::acknowledged;
        const bool is_timeout = code == errc::timeout || code == errc::gateway_exception;
        CHECK(c.responses == (code == errc::ok || is_exception ? 1 : 0));
        CHECK(c.exceptions == (is_exception ? 1 : 0));
        CHECK(c.timeouts == (is_timeout ? 1 : 0));
        CHECK(c.crc_errors == (code == errc::bad_crc ? 1 : 0));
        CHECK(c.transport_errors == (is_transport ? 1 : 0));
        CHECK(c.requests + c.unexpected_bytes == 0);
        const std::uint32_t others = c.responses + c.timeouts + c.crc_errors + c.transport_errors;
        CHECK(others + c.malformed == 1);
    }
}

TEST_CASE("two observers of a line get the same, also unexpected bytes") {
    tests::scripted_port port;
    line<tests::scripted_port, both<counters, tally>> on{port, modbus::timing_at(115200)};
    port.say_at(port.time, byte_list(3, 0x55));
    port.device = [](tests::scripted_port& p, const tests::sent_frame&) {
        p.say(500, tests::exception_response(1, 3, 2));
    };
    CHECK(ask(on).exception() == 2);
    const counters& counted = on.observer();
    const tally& told = on.observer();
    CHECK(counted.requests == 1);
    CHECK(counted.responses == 1);
    CHECK(counted.exceptions == 1);
    CHECK(counted.unexpected_bytes == 3);
    CHECK(told.requests == 1);
    CHECK(told.responses == 1);
    CHECK(told.last == status::sent(errc::exception, 2));
    CHECK(told.stray == 3);
    port.device = nullptr;
    CHECK(ask(on).error() == errc::timeout);
    CHECK(counted.timeouts == 1);
    CHECK(told.last.error() == errc::timeout);
}

TEST_CASE("a line without an observer works like any other") {
    tests::scripted_port port;
    line<tests::scripted_port, unobserved> on{port, modbus::timing_at(115200)};
    port.say_at(port.time, byte_list(3, 0x55));
    port.device = [](tests::scripted_port& p, const tests::sent_frame&) {
        p.say(500, tests::read_response(1, {0x1234}));
    };
    CHECK(ask(on).value_or(0) == 0x1234);
    CHECK(port.frames.size() == 1);
    port.device = nullptr;
    CHECK(ask(on).error() == errc::timeout);
}

} // namespace observer_tests
