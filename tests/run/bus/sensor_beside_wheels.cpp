// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A sensor on the line of two wheels: a server of rows whose client has the same rows. The wheels keep their setpoints
// per second and the bound of a stop, whatever the sensor does. What is sent is counted on the wire.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/bus/bus.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/server/row_values.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/cell_sensor.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/served_device.hpp>

namespace sensor_beside_wheels_tests {

using namespace servobus;
using namespace servobus::units;
namespace sensor = tests::cell_sensor;

namespace {

constexpr std::uint32_t baud = 115200;
constexpr auto wheels_node = responds_within(node<zlac8015d::device>{1}, milliseconds(20));
constexpr auto sensor_node = responds_within(node<sensor::device>{9}, milliseconds(20));
constexpr poll_plan plan{
    modbus::timing_at(baud),
    controlled(wheels_node, {.feedback = milliseconds(25), .command_timeout = milliseconds(500)})
        .commands(milliseconds(50)),
    cyclic<sensor::distance, sensor::temperature>(sensor_node, milliseconds(100)),
    cyclic<sensor::is_door_open, sensor::is_guarded>(sensor_node, milliseconds(100))};
static_assert(plan.polls[0].code == 4 && plan.polls[1].code == 2);

using sensor_values =
    row_values<sensor::distance, sensor::temperature, sensor::is_door_open, sensor::is_guarded, sensor::lamp>;
using line_type = scheduled_line<sim::virtual_line>;

struct rig {
    sim::zlac8015d model{};
    sim::station<sim::zlac8015d> station{model};
    sensor_values values{};
    tests::served_device<sensor_values, modbus::timing_at(baud, modbus::timing_mode::strict)> served{
        values, sensor_node.address, baud};
    sim::virtual_line wire{baud};
    line_type on{wire, plan.timing()};
    zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
    bus<plan, line_type, decltype(wheels)> all{on, wheels};

    // Seen on the wire
    std::vector<std::uint8_t> open{};
    std::uint32_t setpoints = 0;
    std::uint32_t to_sensor = 0;
    std::uint64_t stop_end = 0; // of the first stop since it was set to 0

    std::uint64_t next_setpoint_us = 0; // of the program; 0 while it commands none
    int speed = 0;

    rig() {
        wire.attach(station);
        wire.attach(served);
        wire.set_hook(&rig::note, this);
    }
    rig(const rig&) = delete;

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<rig*>(self);
        std::vector<std::uint8_t>& f = r.open;
        f.push_back(b.value);
        if (f.size() != modbus::request_length(f)) return;
        if (f[0] == 1 && f[1] == 0x10 && f[2] == 0x20 && f[3] == 0x88) ++r.setpoints;
        if (f[0] == 9) ++r.to_sensor;
        const bool is_stop = f[0] == 1 && f[1] == 6 && f[2] == 0x20 && f[3] == 0x0E && f[5] == 5;
        if (is_stop && r.stop_end == 0) r.stop_end = b.at_us;
        f.clear();
    }
    /// One iteration of the program's loop, which commands another speed every 50 ms.
    void turn() {
        // The time of the measurement, which shows the age of a value without the library.
        values.set<sensor::distance>(static_cast<std::uint16_t>(wire.time_us() / 1000));
        if (next_setpoint_us != 0 && wire.time_us() >= next_setpoint_us && wheels.is_idle()) {
            speed = speed == 30 ? 31 : 30;
            CHECK(wheels.begin(velocity{speed * r_per_min, speed * r_per_min}) == errc::ok);
            next_setpoint_us += 50'000;
        }
        wire.wait(longer_of(microseconds(1), all.step()));
    }
    void run(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000;
        while (wire.time_us() < end) turn();
    }
    template <class Wanted> void command(const Wanted& wanted) {
        REQUIRE(wheels.begin(wanted) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !wheels.is_idle(); left.use()) turn();
        REQUIRE(wheels.last());
    }
    void drive() {
        if (wheels.state() == zlac8015d::drive_state::needs_init) command(init{});
        command(zlac8015d::enable_in{zlac8015d::operating_mode::velocity});
        next_setpoint_us = wire.time_us();
        run(500);
    }
    /// The setpoints on the wire in so many seconds.
    std::uint32_t setpoints_in(std::uint32_t seconds) {
        setpoints = 0;
        run(seconds * 1000);
        CHECK(wheels.state() == zlac8015d::drive_state::enabled);
        return setpoints;
    }
    std::uint32_t age_of(std::uint16_t distance) const {
        return static_cast<std::uint16_t>(wire.time_us() / 1000 - distance);
    }
};

/// The ways in which a sensor gives no value.
enum class fault { absent, wrong_crc };
void spoil(rig& r, fault how, bool is_spoilt) {
    if (how == fault::absent) r.wire.set_connected(1, !is_spoilt);
    if (how == fault::wrong_crc) r.served.set_wrong_crc(is_spoilt);
}

} // namespace

TEST_CASE("the values of a sensor beside wheels are those of its server") {
    rig r;
    r.drive();
    r.values.set<sensor::temperature>(raw(-123));
    r.values.set<sensor::is_door_open>(true);
    r.run(300);
    const auto analog = r.all.latest<sensor::distance, sensor::temperature>(sensor_node, milliseconds(150));
    REQUIRE(analog);
    CHECK(analog->get<sensor::temperature>().count() == -123);
    const auto bits = r.all.latest<sensor::is_door_open, sensor::is_guarded>(sensor_node, milliseconds(150));
    REQUIRE(bits);
    CHECK((bits->get<sensor::is_door_open>() && bits->get<sensor::is_guarded>()));
    r.values.set<sensor::is_door_open>(false);
    r.run(300);
    CHECK(!*r.all.latest<sensor::is_door_open>(sensor_node, milliseconds(150)));
}

TEST_CASE("values of a sensor that are taken are not older than what was asked for") {
    rig r;
    r.drive();
    r.run(300);
    std::uint32_t oldest = 0;
    for (unsigned i = 0; i < 4000; ++i) {
        r.turn();
        const auto distance = r.all.latest<sensor::distance>(sensor_node, milliseconds(150));
        REQUIRE(distance);
        const std::uint32_t age = r.age_of(*distance);
        oldest = age > oldest ? age : oldest;
    }
    CHECK(oldest >= 95); // read every 100 ms
    CHECK(oldest <= 130);
    r.wire.set_connected(1, false);
    std::uint32_t last = 0;
    const auto distance = [&] { return r.all.latest<sensor::distance>(sensor_node, milliseconds(150)); };
    for (auto v = distance(); v; v = distance()) {
        last = r.age_of(*v);
        r.turn();
    }
    CHECK(last <= 155);
    r.run(3000);
    CHECK(r.all.latest<sensor::distance>(sensor_node, milliseconds(150)).error() == errc::timeout);
    CHECK(r.all.latest<sensor::is_door_open>(sensor_node, milliseconds(150)).error() == errc::timeout);
}

TEST_CASE("G28: wheels keep their setpoints per second while the sensor is present, absent and returning") {
    for (const fault how : {fault::absent, fault::wrong_crc}) {
        CAPTURE(static_cast<int>(how));
        rig r;
        r.drive();
        const std::uint32_t before = r.to_sensor;
        CHECK(r.setpoints_in(10) == 200);
        CHECK(r.to_sensor - before >= 195);
        spoil(r, how, true);
        CHECK(r.setpoints_in(10) == 200); // with the reads before it counts as absent
        CHECK(r.all.is_absent(9));
        const std::uint32_t asked = r.to_sensor;
        CHECK(r.setpoints_in(10) == 200);
        CHECK(r.to_sensor - asked <= 11); // every retry_every
        spoil(r, how, false);
        const std::uint64_t back = r.wire.time_us();
        r.setpoints = 0;
        while (r.all.is_absent(9)) r.turn();
        CHECK(r.wire.time_us() - back <= plan.rediscovery_bound(2).us);
        r.run(10'000 - static_cast<std::uint32_t>((r.wire.time_us() - back) / 1000));
        CHECK(r.setpoints == 200);
        CHECK(r.all.latest<sensor::distance>(sensor_node, milliseconds(150)));
        CHECK(r.all.latest<sensor::is_door_open>(sensor_node, milliseconds(150)));
        CHECK(r.wire.collisions() == 0);
        CHECK_FALSE(r.model.in_watchdog_stop());
    }
}

TEST_CASE("wheels keep their setpoints per second while a sensor goes and returns in each second") {
    for (unsigned ms = 90; ms < 1000; ms += 170) {
        CAPTURE(ms);
        rig r;
        r.drive();
        r.setpoints = 0;
        const std::uint64_t begun = r.wire.time_us();
        for (unsigned k = 0; k < 10; ++k) {
            r.wire.set_connected(1, false);
            r.run(ms);
            r.wire.set_connected(1, true);
            r.run(1000 - ms);
        }
        const auto passed = static_cast<std::uint32_t>((r.wire.time_us() - begun) / 1000);
        CHECK(r.setpoints >= passed / 50 - 1);
    }
}

TEST_CASE("G25: a stop of the wheels is on the wire within the plan's bound, whatever the sensor does") {
    constexpr std::uint64_t bound = plan.worst_case_stop_latency().us;
    for (const unsigned kind : {0u, 1u, 2u}) {
        CAPTURE(kind);
        rig r;
        std::uint64_t longest = 0;
        for (unsigned k = 0; k < 30; ++k) {
            r.wire.set_connected(1, true);
            r.served.set_wrong_crc(false);
            r.drive();
            if (kind == 1) r.wire.set_connected(1, false);
            if (kind == 2) r.served.set_wrong_crc(true);
            r.next_setpoint_us = 0;
            for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
            // While a request to the sensor is on the wire, its response is awaited, or shortly after.
            const std::uint32_t asked = r.to_sensor;
            while (r.to_sensor == asked) r.turn();
            const std::uint64_t begin = r.wire.time_us() + k * 1733 % 25'000;
            while (r.wire.time_us() < begin) r.turn();
            r.stop_end = 0;
            const std::uint64_t commanded = r.wire.time_us();
            REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
            while (r.stop_end == 0) r.turn();
            const std::uint64_t took = r.stop_end - commanded;
            CHECK(took <= bound);
            longest = took > longest ? took : longest;
            for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
            REQUIRE(r.wheels.last());
            r.run(1000);
        }
        if (kind == 1) CHECK(longest > 15'000); // a response was awaited
    }
}

} // namespace sensor_beside_wheels_tests
