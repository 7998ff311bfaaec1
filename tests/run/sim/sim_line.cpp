// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The virtual line as a port: a client that sends before the last frame has left, that reads in pieces or not
// at all; devices that are disconnected during a response, or that respond together; and faults by their
// names.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

namespace sim_line_tests {

using namespace servobus;

namespace {

using frame = std::vector<std::uint8_t>;

/// Sends a frame each time that it receives the byte `asks`.
struct parrot final : sim::line_device {
    frame says;
    std::uint8_t asks = 0xA5;
    std::uint32_t rate = 115200;
    unsigned due = 0;
    unsigned garbled = 0;
    frame heard;

    parrot() = default;
    explicit parrot(frame what) : says{std::move(what)} {}

    void receive(std::uint8_t byte, bool is_readable, instant) override {
        heard.push_back(byte);
        garbled += is_readable ? 0u : 1u;
        due += byte == asks ? 1u : 0u;
    }
    duration run(instant) override { return until_it_receives; }
    bytes send(instant) override {
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

/// All received bytes, read in pieces.
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

TEST_CASE("a frame longer than any of Modbus is sent unchanged") {
    sim::virtual_line wire{115200};
    parrot device;
    wire.attach(device);
    REQUIRE(*wire.send(numbered(512)) == 512);
    wire.pass(milliseconds(100));
    CHECK(device.heard == numbered(512));
}

TEST_CASE("a frame that is sent before the last has left follows it; bytes without room are not taken") {
    sim::virtual_line wire{115200};
    parrot device;
    wire.attach(device);
    const frame first{1, 2, 3};
    const frame second{4, 5};
    CHECK(*wire.send(first) == 3);
    wire.pass(microseconds(100)); // one character has been sent
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

TEST_CASE("an empty frame sends nothing, also if each request gets a wrong byte") {
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

TEST_CASE("a response is read in pieces; bytes beyond 8192 are lost") {
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

TEST_CASE("an unplugged port sends nothing and loses the bytes that arrive meanwhile") {
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

TEST_CASE("a port that removes its echo does so once: a response that has arrived is kept") {
    sim::virtual_line wire{sim::line_settings{.baud = 115200, .echoes = true}};
    parrot device{numbered(5)};
    wire.attach(device);
    (void)wire.send(question);
    while (!wire.sent()) {}
    wire.pass(milliseconds(5));
    CHECK(wire.sent());
    CHECK(received(wire) == numbered(5));
}

TEST_CASE("an echo that an adapter delays is lost beyond 512 bytes") {
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

TEST_CASE("a line takes as many devices as its type allows") {
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

TEST_CASE("the rest of a response is lost or garbled if its device is disconnected or the client changes its "
          "baud rate") {
    sim::virtual_line wire{115200};
    parrot device{numbered(40)};
    wire.attach(device);
    (void)wire.send(question);
    wire.pass(microseconds(96 * 11)); // ten characters of the response
    SUBCASE("disconnected") {
        wire.set_connected(0, false);
        wire.pass(milliseconds(10));
        const frame got = received(wire);
        CHECK(got == numbered(got.size()));
        CHECK(got.size() >= 9);
        CHECK(got.size() <= 11);
    }
    SUBCASE("another baud rate") {
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

TEST_CASE("at most eight devices are received at a time, and they garble each other") {
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

TEST_CASE("a device that waits for a gap responds after the frame of another device, one that does not "
          "garbles it") {
    constexpr auto request = hex("01 03 20 A1 00 01 DE 28"); // bus voltage
    constexpr std::uint64_t character = 96;
    constexpr std::uint64_t gap = 1750;
    constexpr std::size_t foreign = 40;
    for (const bool listens : {false, true}) {
        for (const std::uint32_t delay_ms : {1u, 20u}) { // the other frame ends after 3.84 ms
            CAPTURE(listens);
            CAPTURE(delay_ms);
            sim::zlac8015d drive;
            sim::station station{drive, milliseconds(delay_ms)};
            station.set_listening(listens);
            parrot other{frame(foreign, 7)};
            other.asks = 0x28; // it begins when the request has ended
            sim::virtual_line wire{115200};
            wire.attach(station);
            wire.attach(other);
            std::vector<std::uint64_t> passed;
            wire.set_hook(
                [](void* to, const sim::wire_byte& b) {
                    static_cast<std::vector<std::uint64_t>*>(to)->push_back(b.at_us);
                },
                &passed);
            wire.pass(milliseconds(5));
            REQUIRE(wire.send(request));
            wire.pass(milliseconds(50));
            REQUIRE(passed.size() == 8 + foreign + 7);
            const bool collides = !listens && delay_ms == 1;
            CHECK((wire.collisions() != 0) == collides);
            const frame got = received(wire);
            REQUIRE(got.size() == foreign + 7);
            const bytes last{got.data() + foreign, 7};
            CHECK(same_bytes(last, hex("01 03 02 09 60 BE 3C")) == !collides);
            if (collides) continue;
            const std::uint64_t due = delay_ms == 1 ? passed[7 + foreign] + gap : passed[7] + 20'000;
            CHECK(passed[8 + foreign] >= due + character);
            CHECK(passed[8 + foreign] <= due + character + 50);
        }
    }
}

// Faults

TEST_CASE("faults have names, and a word that only begins like a name is refused") {
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

TEST_CASE("an unplugged fault plan loses every frame, and faults leave an empty frame empty") {
    sim::fault_source faults{1};
    CHECK_FALSE(faults.decide().is_lost);
    CHECK_FALSE(faults.decide_request().is_lost);
    faults.plan().is_unplugged = true;
    CHECK(faults.decide().is_lost);
    CHECK(faults.decide_request().is_lost);
    std::array<std::uint8_t, sim::max_spoiled> out{};
    CHECK(sim::spoil({.is_cut = true, .is_corrupted = true, .noise_before = 2}, {}, out) == 0);
}

} // namespace sim_line_tests
