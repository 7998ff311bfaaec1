// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client follows its drive to a new baud rate, whenever the drive takes it and whichever frame is lost.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>

#include <servobus/client/change_baud_rate.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/line_setting.hpp>

namespace change_baud_rate_tests {

using namespace servobus;

namespace {

constexpr baud_change faster{9600, 115200};

struct changer {
    static constexpr profile facts{.name = "changer"};
};
inline constexpr reg<u16, access::rw, changer> rate{0x0010, {0, 1}, no_unit, 0, communication};

struct rate_setting {
    static constexpr std::uint16_t at = rate.address;
    static constexpr std::uint16_t initial = 0;
    static std::uint8_t address(std::uint16_t) { return 1; }
    static std::uint32_t baud(std::uint16_t value) { return value == 0 ? faster.from : faster.to; }
};
using changeable = tests::settable<rate_setting>;
using changes = tests::takes_effect;

struct rig {
    changeable device;
    tests::settable_station<rate_setting> station{device};
    sim::virtual_line wire{faster.from};
    line<sim::virtual_line> bus{wire, modbus::timing_at(faster.from)};
    client<line<sim::virtual_line>, changer> at{bus, node<changer>{1}};
    unsigned settings = 0;
    errc refusal = errc::ok; // of the port, after `accepts` settings
    unsigned accepts = 0;

    rig() { wire.attach(station); }

    status change(std::uint16_t code = 1) {
        return change_baud_rate<rate>(at, checked(code), faster, [&](std::uint32_t baud) {
            if (++settings > accepts && refusal != errc::ok) return refusal;
            wire.set_baud(baud);
            return errc::ok;
        });
    }
    bool is_at(std::uint32_t baud) {
        const modbus::rtu_timing wanted = modbus::timing_at(baud);
        return bus.timing().character == wanted.character && bus.timing().t3_5 == wanted.t3_5;
    }
};

} // namespace

TEST_CASE("G24: the client follows its drive, whether the response comes at the old rate, the new one, or "
          "neither") {
    for (const changes when : {changes::before_its_response, changes::after_its_response}) {
        for (const unsigned lost : {0u, 1u}) {
            CAPTURE(when);
            CAPTURE(lost);
            rig r;
            r.device.when = when;
            r.station.lost_responses = lost;
            CHECK(r.change());
            CHECK(r.is_at(faster.to));
            CHECK(r.device.writes == 1);
            const auto held = r.at.read<rate>();
            REQUIRE(held);
            CHECK(*held == 1);
        }
    }
}

TEST_CASE("G24: a drive that takes its new rate when it starts again is reported as not reached yet") {
    for (const unsigned lost : {0u, 1u}) {
        CAPTURE(lost);
        rig r;
        r.device.when = changes::at_power_on;
        r.station.lost_responses = lost;
        CHECK(r.change().error() == errc::not_reached);
        CHECK(r.is_at(faster.from));
        CHECK(r.device.held == 1);
        CHECK(r.at.read<rate>());
    }
}

TEST_CASE(
    "G24: a change of the baud rate that the drive, the line or the port refuses ends with its reason") {
    rig r;
    SUBCASE("an exception: the rate stays") {
        r.device.refuses = true;
        CHECK(r.change().outcome() == outcome::refused);
        CHECK(r.settings == 0);
        CHECK(r.is_at(faster.from));
    }
    SUBCASE("a code outside the register's range: nothing is sent") {
        CHECK(r.change(2).error() == errc::out_of_range);
        CHECK(r.device.writes == 0);
        CHECK(r.settings == 0);
    }
    SUBCASE("no response at either rate: the old one is left") {
        r.station.is_gone_after_a_write = true;
        const status w = r.change();
        CHECK(w.outcome() == outcome::unknown);
        CHECK(w.error() == errc::timeout);
        CHECK(r.is_at(faster.from));
        CHECK(r.settings == 4);
    }
    SUBCASE("the port refuses the first rate") {
        r.refusal = errc::bad_argument;
        const status w = r.change();
        CHECK(w.outcome() == outcome::unknown);
        CHECK(w.error() == errc::bad_argument);
    }
    SUBCASE("the port refuses the way back") {
        r.station.is_gone_after_a_write = true;
        r.refusal = errc::port_lost;
        r.accepts = 3;
        CHECK(r.change().error() == errc::port_lost);
        CHECK(r.settings == 4);
    }
}

TEST_CASE("a line refuses another timing while an exchange is in progress") {
    rig r;
    const auto request = modbus::read_frame(1, rate.address, 1);
    std::array<std::uint8_t, 8> response{};
    modbus::exchange x{request, response, r.bus.timing(), r.at.node().limits};
    while (x.is_to_leave()) r.wire.wait(r.bus.step(x, {}));
    CHECK(r.bus.retime(modbus::timing_at(faster.to)) == errc::busy);
    CHECK(r.is_at(faster.from));
    while (!x.done()) r.wire.wait(r.bus.step(x, {}));
    CHECK(x.status().error() == errc::ok);
    CHECK(r.bus.is_echo_ruled_out());
    CHECK(r.bus.retime(modbus::timing_at(faster.to)) == errc::ok);
    CHECK(r.is_at(faster.to));
    CHECK_FALSE(r.bus.is_echo_ruled_out());
}

TEST_CASE("G24: a C630S takes a new baud rate immediately, a ZLAC8015D when it starts again") {
    const auto set = [](sim::virtual_line& wire) {
        return [&wire](std::uint32_t baud) {
            wire.set_baud(baud);
            return errc::ok;
        };
    };
    sim::c630s servo;
    sim::station at_servo{servo};
    sim::virtual_line wire{57600};
    wire.attach(at_servo);
    line servo_line{wire, modbus::timing_at(57600)};
    client axis{servo_line, node<c630s::device>{1}};
    CHECK(change_baud_rate<c630s::rs485_baud_rate>(axis, c630s::baud_rate::baud_9600, {57600, 9600},
                                                   set(wire)));
    CHECK(axis.read<c630s::software_version>());
    CHECK(servo.baud() == 9600);

    sim::zlac8015d wheels;
    sim::station at_wheels{wheels};
    sim::virtual_line other{115200};
    other.attach(at_wheels);
    line wheels_line{other, modbus::timing_at(115200)};
    client both{wheels_line, node<zlac8015d::device>{1}};
    const status w = change_baud_rate<zlac8015d::rs485_baud_rate>(both, zlac8015d::baud_rate::baud_9600,
                                                                  {115200, 9600}, set(other));
    CHECK(w.error() == errc::not_reached);
    CHECK(both.read<zlac8015d::bus_voltage>());
}

} // namespace change_baud_rate_tests
