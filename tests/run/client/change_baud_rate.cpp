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
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/line_setting.hpp>
#include <tests/support/simulated_c630s.hpp>

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
    static constexpr std::uint32_t baud(std::uint16_t value) { return value == 0 ? faster.from : faster.to; }
};

struct rig : tests::line_setting_rig<rate_setting, changer> {
    static constexpr const auto& row = rate;
    static constexpr std::uint16_t wanted = 1;
    unsigned settings = 0;
    errc refusal = errc::ok; // of the port, after `accepts` settings
    unsigned accepts = 0;

    status change(std::uint16_t code = wanted) {
        return change_baud_rate<rate>(at, checked(code), faster, [&](std::uint32_t baud) {
            if (++settings > accepts && refusal != errc::ok) return refusal;
            wire.set_baud(baud);
            return errc::ok;
        });
    }
    bool is_at(std::uint32_t bits_a_second) const {
        const modbus::rtu_timing of_it = modbus::timing_at(bits_a_second);
        return line.timing().character == of_it.character && line.timing().t3_5 == of_it.t3_5;
    }
    bool is_changed() const { return is_at(faster.to); }
    bool is_unchanged() const { return is_at(faster.from); }
    void follow() {
        wire.set_baud(faster.to);
        CHECK(line.retime(modbus::timing_at(faster.to)) == errc::ok);
    }
};

} // namespace

TEST_CASE("G24: the client follows its drive, whether the response comes at the old rate, the new one, or "
          "neither") {
    tests::play_a_change_in_operation<rig>();
}

TEST_CASE("G24: a drive that takes its new rate when it starts again is reported as not reached yet") {
    tests::play_a_change_at_power_on<rig>();
}

TEST_CASE("G7, G24: a change of the baud rate keeps the kind of timing and the longest pause in a response") {
    rig r;
    modbus::timing_mode mode{};
    SUBCASE("host timing") { mode = modbus::timing_mode::host; }
    SUBCASE("strict timing") { mode = modbus::timing_mode::strict; }
    REQUIRE(r.line.retime(modbus::timing_at(faster.from, mode, milliseconds(50))) == errc::ok);
    CHECK(r.change());
    CHECK(r.is_at(faster.to));
    CHECK(r.line.timing().mode == mode);
    CHECK(r.line.timing().inter_byte == milliseconds(50));
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
    modbus::exchange x{request, response, r.line.timing(), r.at.node().limits};
    while (x.is_to_leave()) r.wire.wait(r.line.step(x, {}));
    CHECK(r.line.retime(modbus::timing_at(faster.to)) == errc::busy);
    CHECK(r.is_at(faster.from));
    while (!x.done()) r.wire.wait(r.line.step(x, {}));
    CHECK(x.status().error() == errc::ok);
    CHECK(r.line.is_echo_ruled_out());
    CHECK(r.line.retime(modbus::timing_at(faster.to)) == errc::ok);
    CHECK(r.is_at(faster.to));
    CHECK_FALSE(r.line.is_echo_ruled_out());
}

TEST_CASE("G24: a C630S takes a new baud rate immediately, a ZLAC8015D when it starts again") {
    const auto set = [](sim::virtual_line& wire) {
        return [&wire](std::uint32_t baud) {
            wire.set_baud(baud);
            return errc::ok;
        };
    };
    simulated::simulated_c630s servo;
    client axis{servo.line, node<c630s::device>{1}};
    CHECK(change_baud_rate<c630s::rs485_baud_rate>(axis, c630s::baud_rate::baud_9600, {57600, 9600},
                                                   set(servo.wire)));
    CHECK(axis.read<c630s::software_version>());
    CHECK(servo.model.baud() == 9600);

    simulated::simulated_model<sim::zlac8015d, sim::zlac8015d_options, 115200> wheels;
    client both{wheels.line, node<zlac8015d::device>{1}};
    const status w = change_baud_rate<zlac8015d::rs485_baud_rate>(both, zlac8015d::baud_rate::baud_9600,
                                                                  {115200, 9600}, set(wheels.wire));
    CHECK(w.error() == errc::not_reached);
    CHECK(both.read<zlac8015d::bus_voltage>());
}

} // namespace change_baud_rate_tests
