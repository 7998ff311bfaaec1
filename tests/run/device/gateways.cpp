// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive that is gone for seconds while a gateway responds in its place: its facade behaves as with no response at
// all. The simulated motors, seen from outside, do not turn again by themselves.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/servobus.hpp>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/gateway.hpp>

namespace gateways_tests {

using namespace servobus;
using namespace servobus::units;
using tests::modbus_tcp_gateway;
using tests::rtu_gateway;

namespace {

template <class Device, class Port> node<Device> node_behind() {
    node<Device> n{1};
    n.limits.has_gateway = !Port::has_gateway;
    return n;
}

/// What happened while a program commanded a motion every 100 ms for 8 s.
struct course {
    unsigned begun = 0;
    unsigned refused = 0;
    std::uint64_t needs_init_after = 0; ///< us; 0: never
};
template <class Drive, class Command, class Line>
course command_for_8_s(Drive& drive, const Command& go, Line& on, sim::virtual_line& wire, bool& is_cut) {
    course c;
    const std::uint64_t begin = wire.time_us();
    std::uint64_t next = begin;
    is_cut = true;
    while (wire.time_us() < begin + 8'000'000) {
        if (wire.time_us() > begin + 5'000'000) is_cut = false;
        if (wire.time_us() >= next && drive.is_idle()) {
            next += 100'000;
            ++(drive.begin(go) == errc::ok ? c.begun : c.refused);
        }
        const duration idle = drive.step();
        on.sleep(idle < milliseconds(5) ? idle : milliseconds(5));
        if (c.needs_init_after == 0 && !drive.is_initialised()) c.needs_init_after = wire.time_us() - begin;
    }
    return c;
}

template <class Base> struct watched : Base {
    using Base::Base;
    bool is_initialised() const { return this->state() != decltype(this->state())::needs_init; }
};

} // namespace

TEST_CASE_TEMPLATE(
    "G20, G21, G38, S3: wheels whose drive was gone while a gateway responded do not turn again", Port,
    modbus_tcp_gateway, rtu_gateway) {
    namespace z = zlac8015d;
    for (const std::uint8_t number : {std::uint8_t{0x0A}, std::uint8_t{0x0B}, std::uint8_t{0}}) {
        CAPTURE(int{number});
        sim::zlac8015d machine;
        sim::station station{machine};
        sim::virtual_line wire{115200};
        wire.attach(station);
        Port port{wire};
        port.number = number;
        line on{port, modbus::timing_at(115200)};
        watched<z::drive<line<Port>>> drive{
            on,
            node_behind<z::device, Port>(),
            {.feedback = milliseconds(50), .command_timeout = milliseconds(500)}};
        const velocity go{20 * r_per_min, 20 * r_per_min};
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(z::watchdog{1 * second}));
        REQUIRE(drive.run(enable{}));
        REQUIRE(drive.run(go));
        wire.pass(milliseconds(300));
        REQUIRE(machine.left().speed > 0);
        const course c = command_for_8_s(drive, go, on, wire, port.is_cut);
        CHECK(c.needs_init_after != 0);
        CHECK(c.needs_init_after < 1'100'000);
        CHECK(c.begun <= 2);
        CHECK(c.refused > 60);
        CHECK(machine.left().speed == 0);
        CHECK(machine.right().speed == 0);
        CHECK(drive.state() == z::drive_state::needs_init);
        CHECK((port.exceptions != 0) == (number != 0));
    }
}

TEST_CASE_TEMPLATE(
    "G21, G28, G38: a stepper that is gone while a gateway responds is absent, and takes no move", Port,
    modbus_tcp_gateway, rtu_gateway) {
    namespace y = yako;
    sim::yako_closed_loop machine;
    sim::station station{machine};
    sim::virtual_line wire{115200};
    wire.attach(station);
    Port port{wire};
    line on{port, modbus::timing_at(115200)};
    watched<y::closed_loop::drive<line<Port>>> drive{on, node_behind<y::closed_loop::device, Port>()};
    REQUIRE(drive.run(init{}));
    REQUIRE(drive.run(enable{}));
    port.is_cut = true;
    const std::uint64_t begin = wire.time_us();
    while (wire.time_us() < begin + 2'000'000) on.sleep(drive.step());
    CHECK(drive.is_absent());
    const unsigned polls = port.exceptions;
    CHECK(polls > 2);
    CHECK(polls < 10); // backed off
    const auto before = machine.view().shaft;
    CHECK_FALSE(drive.run(move_by{1000 * pulse}));
    port.is_cut = false;
    wire.pass(milliseconds(2000));
    CHECK(machine.view().shaft == before);
}

TEST_CASE_TEMPLATE(
    "G21, G38: a servo whose velocity may have been lost behind a gateway is not reported as turning", Port,
    modbus_tcp_gateway, rtu_gateway) {
    namespace c = c630s;
    sim::c630s machine;
    sim::station station{machine};
    sim::virtual_line wire{57600};
    wire.attach(station);
    Port port{wire};
    line on{port, modbus::timing_at(57600)};
    watched<c::drive<line<Port>>> drive{on, node_behind<c::device, Port>()};
    REQUIRE(drive.run(init{}));
    REQUIRE(drive.run(c::set_up{}));
    machine.power_cycle();
    REQUIRE(drive.run(init{}));
    REQUIRE(drive.run(c::enable_in{c::control_mode::speed}));
    REQUIRE(drive.run(velocity{100 * r_per_min}));
    port.is_cut = true;
    const command_status s = drive.run(velocity{200 * r_per_min});
    CHECK(s.outcome() != outcome::done);
    CHECK(s.outcome() != outcome::refused);
    CHECK(s.error() == errc::gateway_exception);
    CHECK_FALSE(drive.run(velocity{300 * r_per_min}));
    CHECK(port.exceptions != 0);
}

} // namespace gateways_tests
