// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The virtual line as a port sees it: a client that sends before the last frame has left, reads in pieces or
// not at all; devices that are taken away in the middle of a response, or that answer all at once; and faults
// by their names.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>

using namespace servobus;

namespace {

using frame = std::vector<std::uint8_t>;

/// Says a frame as soon as `asks` is heard, as often as that.
struct parrot final : sim::line_device {
    frame says;
    std::uint8_t asks = 0xA5;
    std::uint32_t rate = 115200;
    unsigned due = 0;
    unsigned garbled = 0;
    frame heard;

    parrot() = default;
    explicit parrot(frame what) : says{std::move(what)} {}

    void hear(std::uint8_t byte, bool is_readable, instant) override {
        heard.push_back(byte);
        garbled += is_readable ? 0u : 1u;
        due += byte == asks ? 1u : 0u;
    }
    duration run(instant) override { return until_it_hears; }
    bytes talk(instant) override {
        if (due == 0) return {};
        --due;
        return says;
    }
    std::uint32_t baud() const override { return rate; }
};

frame numbered(std::size_t size) {
    frame f;
    for (std::size_t i = 0; i < size; ++i) f.push_back(static_cast<std::uint8_t>(i & 0x7F));
    return f;
}

/// All that has come, read by pieces.
template <class Wire> frame received(Wire& wire, std::size_t piece = 256) {
    frame all;
    frame in(piece);
    while (true) {
        const auto n = wire.receive(in);
        if (!n || *n == 0) return all;
        all.insert(all.end(), in.begin(), in.begin() + *n);
    }
}

constexpr std::array<std::uint8_t, 1> question{0xA5};

} // namespace

// The client

TEST_CASE("a frame longer than any of Modbus leaves as it was given") {
    sim::virtual_line wire{115200};
    parrot device;
    wire.attach(device);
    REQUIRE(*wire.send(numbered(512)) == 512);
    wire.pass(milliseconds(100));
    CHECK(device.heard == numbered(512));
}

TEST_CASE("a frame that is sent before the last has left goes behind it; what finds no room is not taken") {
    sim::virtual_line wire{115200};
    parrot device;
    wire.attach(device);
    const frame first{1, 2, 3};
    const frame second{4, 5};
    CHECK(*wire.send(first) == 3);
    wire.pass(microseconds(100)); // one character is out
    CHECK(*wire.send(second) == 2);
    CHECK_FALSE(wire.sent());
    wire.pass(milliseconds(1));
    CHECK(wire.sent());
    CHECK(device.heard == frame{1, 2, 3, 4, 5});
    CHECK(wire.requests() == 1);
    CHECK(*wire.send(numbered(600)) == 512);
    wire.pass(milliseconds(100));
    CHECK(device.heard.size() == 5 + 512);
}

TEST_CASE("an empty frame is none, also where each request gets a wrong byte") {
    sim::virtual_line wire{115200};
    parrot device;
    wire.attach(device);
    wire.faults().corrupted_request = 1000;
    CHECK(*wire.send({}) == 0);
    wire.pass(milliseconds(1));
    CHECK(wire.sent());
    CHECK(device.heard.empty());
    CHECK(*wire.send(frame{1, 2, 3}) == 3);
    wire.pass(milliseconds(1));
    CHECK(device.heard.size() == 3);
    CHECK(device.heard != frame{1, 2, 3});
}

TEST_CASE("a response is read in pieces; what comes beyond 8192 bytes is lost") {
    sim::virtual_line wire{115200};
    parrot device{numbered(200)};
    wire.attach(device);
    (void)wire.send(question);
    wire.pass(milliseconds(30));
    CHECK(received(wire, 7) == numbered(200));
    for (int i = 0; i < 50; ++i) {
        (void)wire.send(question);
        wire.pass(milliseconds(30));
    }
    const frame all = received(wire);
    CHECK(all.size() == 8192);
    CHECK(frame(all.begin() + 200, all.begin() + 400) == numbered(200));
}

TEST_CASE("an unplugged port sends nothing and loses what arrives meanwhile") {
    sim::virtual_line wire{115200};
    parrot device{numbered(20)};
    wire.attach(device);
    (void)wire.send(question);
    wire.pass(milliseconds(1)); // the response has begun
    wire.unplug();
    CHECK(wire.send(question).error() == errc::port_lost);
    std::array<std::uint8_t, 8> in{};
    CHECK(wire.receive(in).error() == errc::port_lost);
    wire.pass(milliseconds(10));
    wire.plug();
    CHECK(received(wire).empty());
    (void)wire.send(question);
    wire.pass(milliseconds(10));
    CHECK(received(wire) == numbered(20));
}

TEST_CASE("a port that takes its echo away does so once: a response that has come stays") {
    sim::virtual_line wire{sim::line_settings{.baud = 115200, .echoes = true}};
    parrot device{numbered(5)};
    wire.attach(device);
    (void)wire.send(question);
    while (!wire.sent()) {}
    wire.pass(milliseconds(5));
    CHECK(wire.sent());
    CHECK(received(wire) == numbered(5));
}

TEST_CASE("an echo that waits behind an adapter is lost beyond 512 bytes") {
    sim::virtual_line wire{sim::line_settings{
        .baud = 115200, .echoes = true, .keeps_echo = true, .echo_delay = milliseconds(500)}};
    for (int i = 0; i < 3; ++i) {
        CHECK(*wire.send(numbered(200)) == 200);
        wire.pass(milliseconds(30));
        REQUIRE(wire.sent());
    }
    wire.pass(milliseconds(1500));
    const frame got = received(wire);
    REQUIRE(got.size() == 512);
    for (std::size_t i = 0; i < 512; ++i) CHECK(got[i] == numbered(200)[i % 200]);
}

// The devices

TEST_CASE("a line holds as many devices as it is made for") {
    sim::basic_virtual_line<2> wire{115200};
    std::array<parrot, 3> devices{};
    CHECK(wire.attach(devices[0]));
    CHECK(wire.attach(devices[1]));
    CHECK_FALSE(wire.attach(devices[2]));
    (void)wire.send(frame{1, 2});
    wire.pass(milliseconds(1));
    CHECK(devices[1].heard == frame{1, 2});
    CHECK(devices[2].heard.empty());
}

TEST_CASE("a device that is taken off, or a client that changes its rate, spoils the rest of a response") {
    sim::virtual_line wire{115200};
    parrot device{numbered(40)};
    wire.attach(device);
    (void)wire.send(question);
    wire.pass(microseconds(96 * 11)); // ten characters of the response
    SUBCASE("taken off") {
        wire.set_connected(0, false);
        wire.pass(milliseconds(10));
        const frame got = received(wire);
        CHECK(got == numbered(got.size()));
        CHECK(got.size() >= 9);
        CHECK(got.size() <= 11);
    }
    SUBCASE("another rate") {
        wire.set_baud(9600);
        wire.pass(milliseconds(10));
        const frame got = received(wire);
        REQUIRE(got.size() == 40);
        CHECK(frame(got.begin(), got.begin() + 9) == numbered(9));
        for (std::size_t i = 12; i < 40; ++i) CHECK(got[i] != numbered(40)[i]);
    }
    SUBCASE("the wire breaks") {
        wire.faults().is_unplugged = true;
        wire.pass(milliseconds(10));
        const frame got = received(wire);
        CHECK(got == numbered(got.size()));
        CHECK(got.size() <= 11);
    }
}

TEST_CASE("eight devices at most are heard at a time, and spoil each other") {
    sim::virtual_line wire{115200};
    std::vector<parrot> devices(9, parrot{frame{7, 7, 7}});
    for (parrot& d : devices) wire.attach(d);
    (void)wire.send(question);
    wire.pass(milliseconds(10));
    CHECK(wire.responses() == 9);
    CHECK(wire.collisions() >= 8 * 3 - 1);
    const frame got = received(wire);
    REQUIRE(got.size() == 8 * 3);
    for (std::size_t i = 0; i + 1 < got.size(); ++i) CHECK(got[i] != 7);
}

// Faults

TEST_CASE("faults have names, and a word that only begins like one is none") {
    const auto parsed = [](const std::string& text) {
        sim::fault_plan plan;
        plan.lost_response = 999;
        return sim::parse_faults(text.c_str(), plan) ? plan : sim::fault_plan{.lost_request = 1};
    };
    CHECK(parsed("none").lost_response == 999);
    CHECK(parsed("unplugged").is_unplugged);
    CHECK(parsed("none,unplugged,late").is_unplugged);
    CHECK(parsed("none,unplugged,late").late_response == 50);
    for (const char* wrong : {"", ",", "late,", "lat", "later", "latelate", "Late", "nonesuch", "unplug"}) {
        CAPTURE(std::string{wrong});
        CHECK(parsed(wrong).lost_request == 1);
    }
}

TEST_CASE("an unplugged plan loses every frame, and of an empty frame nothing is left to spoil") {
    sim::fault_source faults{1};
    CHECK_FALSE(faults.decide().is_lost);
    CHECK_FALSE(faults.decide_request().is_lost);
    faults.plan().is_unplugged = true;
    CHECK(faults.decide().is_lost);
    CHECK(faults.decide_request().is_lost);
    std::array<std::uint8_t, sim::max_spoiled> out{};
    CHECK(sim::spoil({.is_cut = true, .is_corrupted = true, .noise_before = 2}, {}, out) == 0);
}
