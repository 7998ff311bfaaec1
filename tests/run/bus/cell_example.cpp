// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The cell of examples/cell against the simulated drives and a served sensor: all of it moves at once, stops for the
// door and for a sensor that is silent, and is prepared again after a restart. Judged by the simulated machines.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/server/row_values.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <examples/cell/cell.hpp>
#include <tests/support/served_device.hpp>

namespace cell_example_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {

constexpr std::uint32_t baud = cell::shared.baud;
using sensor_values = row_values<eye::distance, eye::is_door_open>;

struct floor_of {
    sim::zlac8015d wheels;
    sim::yako_closed_loop lift;
    sim::c630s press;
    sensor_values values{};
    sim::station<sim::zlac8015d> first{wheels};
    sim::station<sim::yako_closed_loop> second{lift};
    sim::station<sim::c630s> third{press};
    tests::served_device<sensor_values, modbus::timing_at(baud, modbus::timing_mode::strict)> sensor{values,
                                                                                                     9, baud};
    sim::virtual_line wire{baud};
    using line_type = scheduled_line<sim::virtual_line>;
    line_type on{wire, cell::plan.timing()};
    cell::cell<line_type> program{on};

    floor_of() {
        bring_to_the_shared_settings();
        wire.attach(first);
        wire.attach(second);
        wire.attach(third);
        wire.attach(sensor);
        sim::yako_machine rails;
        rails.home_from = -6200;
        rails.home_to = -6000;
        rails.negative_limit = -7000;
        rails.negative_stop = -7400;
        rails.positive_limit = 38'000;
        rails.positive_stop = 38'500;
        lift.attach(rails);
        values.set<eye::distance>(500_mm);
        values.set<eye::is_door_open>(false);
    }
    template <class Drive> static void put(Drive& drive, std::uint16_t address, std::uint16_t value) {
        const std::uint8_t word[]{static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
        REQUIRE(drive.write(address, words_view{word}) == 0);
    }
    /// As each of them was set up alone, by what the settings say that it needs.
    void bring_to_the_shared_settings() {
        const auto& needs = cell::shared.changes;
        put(wheels, needs[0].rate.address, needs[0].rate.code);
        put(wheels, zlac8015d::speed_resolution.address, 10);
        put(wheels, zlac8015d::save_parameters.address, 1);
        wheels.power_cycle();
        lift.set_switches(2);
        put(lift, needs[1].rate.address, needs[1].rate.code);
        put(lift, yako::auxiliary_command.address,
            static_cast<std::uint16_t>(yako::auxiliary::save_parameters));
        lift.power_cycle();
        put(press, c630s::eeprom_update.address, 1);
        put(press, c630s::node_address.address, 3);
        put(press, needs[2].rate.address, needs[2].rate.code);
        if (needs[2].format) put(press, needs[2].format.address, needs[2].format.code);
        press.power_cycle();
        REQUIRE(wheels.baud() == baud);
        REQUIRE(lift.baud() == baud);
        REQUIRE(press.baud() == baud);
    }
    /// As a person does: a C630S that was set up is switched off and on.
    bool prepare() {
        if (program.prepare()) return true;
        press.power_cycle();
        return program.prepare();
    }
    void go(std::uint32_t ms, const twist& by) {
        std::uint32_t next = 0;
        for (std::uint32_t t = 0; t < ms * 10; ++t) {
            (void)program.all.step();
            if (t >= next && program.wheels.is_idle()) {
                (void)program.drive(by);
                next = t + 500;
            }
            wire.pass(microseconds(100));
        }
    }
};
constexpr twist forward{300_mm_per_s, 0_rad_per_s};

} // namespace

TEST_CASE("the cell runs: wheels, lift and press at once, and stops for a door and a silent sensor") {
    floor_of f;
    REQUIRE(f.prepare());
    CHECK(f.program.is_safe());
    f.go(2000, forward);
    CHECK(f.program.wheels.pose().x() > 400_mm);
    CHECK(f.program.wheels.pose().is_continuous);

    const std::int64_t home = f.lift.view().position;
    REQUIRE(f.program.lift.begin(move_to{40_mm, lift::fast}) == errc::ok);
    REQUIRE(f.program.press.begin(c630s::start_segment{press::down}) == errc::ok);
    f.go(3000, forward);
    CHECK(f.program.all.run(f.program.lift, wait_reached{}));
    CHECK(f.lift.view().position - home == 8000);
    CHECK(f.program.all.run(f.program.press, wait_reached{}));

    f.values.set<eye::is_door_open>(true);
    f.go(1500, forward);
    CHECK_FALSE(f.program.is_safe());
    CHECK(f.wheels.stands_still());
    f.values.set<eye::is_door_open>(false);
    f.go(1000, forward);
    CHECK_FALSE(f.wheels.stands_still());
    f.wire.set_connected(3, false);
    f.go(2000, forward);
    CHECK_FALSE(f.program.is_safe());
    CHECK(f.wheels.stands_still());
    f.wire.set_connected(3, true);
    f.go(2000, forward);
    CHECK_FALSE(f.wheels.stands_still());
}

TEST_CASE("after a restart of a drive the others go on, and the cell is prepared again") {
    floor_of f;
    REQUIRE(f.prepare());
    f.go(500, forward);
    f.lift.power_cycle();
    f.go(1500, forward);
    CHECK(f.program.lift.state() == drive_state::needs_init);
    CHECK_FALSE(f.wheels.stands_still());
    REQUIRE(f.program.all.run(f.program.wheels, halt{}));
    CHECK(f.prepare());
    f.wire.faults().lost_response = 20;
    unsigned reached = 0;
    for (int i = 0; i < 6; ++i) {
        const auto a = f.program.all.run(f.program.lift, move_to{i % 2 == 0 ? 10_mm : 20_mm, lift::fast},
                                         wait_reached{});
        reached += a.how == arrival_state::reached ? 1u : 0u;
        if (f.program.lift.state() != drive_state::enabled) (void)f.prepare();
    }
    CHECK(reached >= 3);
}

} // namespace cell_example_tests
