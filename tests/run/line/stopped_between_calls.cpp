// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program that is stopped between two calls of the port, or between two steps, while its request leaves or
// its response is due, with a port or a clock that fails meanwhile.
#include <doctest/doctest.h>

#include <servobus/line/line.hpp>

#include <tests/support/line_rig.hpp>

namespace stopped_between_calls_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::scripted_port;
using word = std::uint16_t;

namespace {

/// `sent` returns late, once, and the port may fail in the next `receive`.
struct stops_in_sent : scripted_port {
    std::uint64_t stop_us = 0;
    errc then = errc::ok;

    bool sent() {
        time += std::exchange(stop_us, 0);
        return scripted_port::sent();
    }
    transfer receive(byte_buffer in) {
        if (frames.empty() || then == errc::ok) return scripted_port::receive(in);
        return std::exchange(then, errc::ok);
    }
};

} // namespace

TEST_CASE(
    "G15, G33: a request that left while the program was stopped counts as sent if the port is lost next") {
    for (const std::uint64_t stop_us :
         {std::uint64_t{1'000}, std::uint64_t{50'000}, std::uint64_t{5'000'000}}) {
        CAPTURE(stop_us);
        rig<stops_in_sent> r;
        r.settle();
        r.port.stop_us = stop_us;
        r.port.then = errc::port_lost;
        CHECK(r.run(write_one).why == status::sent(errc::port_lost));
        CHECK(r.port.count_of(0x06) == 1);
    }
}

TEST_CASE(
    "G1: a clock that went back before an exchange is given up does not shorten the quarantine after it") {
    rig<scripted_port> r;
    r.settle();
    r.limits.response = milliseconds(200);
    // The response to the first request comes after a quarantine, and before its own time limit.
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) {
        const bool is_first = f.data == read_one;
        p.say(is_first ? 150'000u : 60'000u,
              tests::read_response(1, {is_first ? word{0x1111} : word{0x2222}}));
    };
    std::array<std::uint8_t, 16> room{};
    exchange first{read_one, room, r.timing, r.limits};
    while (first.state() != exchange::phase::awaiting) (void)r.on.step(first, r.gaps);
    const std::uint64_t from = r.port.time;
    r.port.clock = [=](std::uint64_t t) { return static_cast<std::uint32_t>(t < from ? t : t - 50'000); };
    CHECK(r.on.is_free()); // by this clock the exchange has taken longer than any can
    const auto next = r.run(read_other);
    CHECK(next.why == errc::ok);
    CHECK(next.response == tests::read_response(1, {0x2222}));
    r.on.abandon(first);
    CHECK(first.status() == status::sent(errc::timeout));
}

} // namespace stopped_between_calls_tests
