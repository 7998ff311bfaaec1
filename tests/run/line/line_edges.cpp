// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line receives one byte at each of its edges: before a request, while it leaves, and after its response. The other
// `line_*` tests play each on every kind of port. They run for more than a moment.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <tests/support/line_rig.hpp>

namespace line_edges_tests {

using namespace tests::whole_line;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;

namespace {

constexpr std::uint64_t t3_5 = 1750, quarantine = 100'000;
constexpr std::uint64_t slack = 500; // until the program sees a byte, and the calls of the port

/// The time from `from` to the begin of the next request, which gets its response.
template <class R> std::uint64_t next_after(R& r, std::uint64_t from) {
    r.port.device = answering(500);
    CHECK(r.run(read_one).why.error() == errc::ok);
    return r.port.frames.back().begin - from;
}

} // namespace

TEST_CASE(
    "G2: after a byte of another node while a request leaves a response of a line begins after a gap, not at "
    "once") {
    const auto ask = [](std::uint8_t byte, std::uint32_t pause) {
        rig<> r;
        r.settle();
        r.limits.response = milliseconds(200);
        r.port.device = [&](scripted_port& p, const sent_frame& f) {
            p.arrive(f.end - 150, byte);
            p.say_at(f.end + pause, one_word);
        };
        return r.run(read_one).why.error();
    };
    CHECK(ask(0x42, 50) == errc::timeout); // the rest of a frame of that node
    CHECK(ask(0x42, 30'000) == errc::ok);
    CHECK(ask(0x00, 50) == errc::ok); // of a driver that is switched
    CHECK(ask(0xFF, 50) == errc::ok);
}

TEST_CASE("G4: an echo that comes while the request leaves keeps no response away, however soon it follows") {
    for (const std::uint32_t pause : {1u, 100u, 700u, 5000u}) {
        CAPTURE(pause);
        tests::scripted_port port;
        port.echoes = port.keeps_echo = true;
        port.device = [&](scripted_port& p, const sent_frame&) { p.say(pause, one_word); };
        line<scripted_port, counters, echoed> on{port, timing_at(115200)};
        std::array<std::uint8_t, 256> room{};
        const response_limits limits;
        exchange x{read_one, room, on.timing(), limits};
        on.run(x, bus_gaps{{}, milliseconds(100)});
        CHECK(x.status().error() == errc::ok);
    }
}

TEST_CASE("G1: a byte between two requests of a line causes a quarantine, but of a switched driver") {
    for (const std::uint8_t byte : {std::uint8_t{0x55}, std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        CAPTURE(byte);
        rig<> r;
        r.settle();
        const std::uint64_t at = r.port.last_arrival() + 30'000; // the gap after the response is over
        r.port.arrive(at, byte);
        while (r.port.time < at + 100) (void)r.port.now(); // the program comes back
        const std::uint64_t gap = next_after(r, at);
        CHECK(gap >= (byte == 0x55 ? quarantine : t3_5));
        CHECK(gap <= (byte == 0x55 ? quarantine + t3_5 : t3_5) + slack);
    }
}

TEST_CASE("G1: a garbled character between two requests of a line causes a quarantine") {
    rig<> r;
    r.settle();
    const std::uint64_t begin = r.port.time + 30'000;
    while (r.port.time < begin) (void)r.port.now();
    r.port.noisy_until = begin + 300;
    const std::uint64_t gap = next_after(r, begin);
    CHECK(gap >= quarantine);
    CHECK(gap <= quarantine + t3_5 + 1000);
}

TEST_CASE("G1: bytes right behind a response cause a quarantine") {
    for (const std::uint8_t byte : {std::uint8_t{0x55}, std::uint8_t{0x00}}) {
        CAPTURE(byte);
        rig<> r;
        r.settle();
        byte_list more = one_word;
        more.push_back(byte);
        r.port.device = [&](scripted_port& p, const sent_frame&) { p.say(500, more); };
        CHECK(r.run(read_one).why.error() == errc::ok);
        const std::uint64_t at = r.port.last_arrival();
        const std::uint64_t gap = next_after(r, at);
        CHECK((gap >= quarantine) == (byte == 0x55));
        CHECK(gap <= (byte == 0x55 ? quarantine + t3_5 + slack : t3_5 + slack));
    }
}

} // namespace line_edges_tests
