// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G21: what becomes of commands, stops and other drives after a register that a facade caches was written by another
// client on its line. Judged by the frames on the wire and by the simulated drive.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/any_device.hpp>
#include <servobus/client/stepped_tables.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_c630s.hpp>
#include <tests/support/enabled_yako.hpp>
#include <tests/support/enabled_zlac8015d.hpp>

namespace after_changed_settings_tests {

using namespace servobus;
using namespace servobus::units;
using zlac8015d::operating_mode;
using rig = simulated::driven_zlac8015d;
using other_client = client<rig::line_type, zlac8015d::device>;

TEST_CASE("G21: a command under way ends, and no frame of it follows the write") {
    // After how many frames of an enable the other client's write leaves.
    for (std::size_t n = 0; n < 12; ++n) {
        CAPTURE(n);
        rig r;
        REQUIRE(r.drive.run(init{}));
        other_client other{r.line, node<zlac8015d::device>{1}};
        const std::size_t before = r.log.frames.size();
        REQUIRE(r.drive.begin(enable{}) == errc::ok);
        while (!r.drive.is_idle() && r.log.frames.size() < before + n) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        REQUIRE_FALSE(r.drive.is_idle());
        while (!other.write<zlac8015d::max_motor_speed>(500))
            r.wire.pass(milliseconds(1)), (void)r.drive.step();
        const std::size_t written = r.log.frames.size();
        while (!r.drive.is_idle()) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
        CHECK(r.drive.last().error() == errc::needs_init);
        CHECK(r.drive.state() == zlac8015d::drive_state::needs_init);
        CHECK(r.log.frames.size() == written);
        CHECK(r.model.enabled() == (r.sent(modbus::write_frame(1, 0x200E, 8)) != 0)); // with zero targets
    }
}

TEST_CASE(
    "G21: a stepped write counts as soon as it begins to leave, and one that is given up before does not") {
    rig r;
    enabled_zlac8015d::be_enabled_in(r, operating_mode::velocity);
    other_client other{r.line, node<zlac8015d::device>{1}};
    {
        stepped_write<other_client, zlac8015d::speed_resolution> call{other};
        REQUIRE(call.begin(10) == errc::ok);
        call.cancel();
        (void)call.step();
        REQUIRE(r.drive.run(velocity{30 * r_per_min, 30 * r_per_min}));
    }
    stepped_write<other_client, zlac8015d::speed_resolution> call{other};
    REQUIRE(call.begin(10) == errc::ok);
    const std::size_t frames = r.log.frames.size();
    while (r.log.open.empty() && r.log.frames.size() == frames) {
        (void)call.step();
        r.wire.wait(microseconds(20));
    }
    (void)call.step();
    CHECK(r.drive.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::needs_init);
    call.cancel();
    CHECK(call.status().outcome() == outcome::unknown);
}

TEST_CASE("G21: a stop under way is completed, and nothing but stops and init follows it") {
    rig r;
    enabled_zlac8015d::be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    r.wire.pass(milliseconds(300));
    other_client other{r.line, node<zlac8015d::device>{1}};
    REQUIRE(r.drive.begin(disable{}) == errc::ok);
    while (!other.write<zlac8015d::speed_resolution>(10)) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    REQUIRE_FALSE(r.drive.is_idle());
    while (!r.drive.is_idle()) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.drive.last());
    CHECK(r.model.stands_still());
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == zlac8015d::drive_state::needs_init);
    CHECK(r.drive.run(disable{}));
    CHECK(r.drive.run(enable{}).error() == errc::needs_init);
}

TEST_CASE("G21: a request that writes a cached register counts though the drive refuses it: 17h") {
    for (const bool is_stepped : {false, true}) {
        CAPTURE(is_stepped);
        rig r;
        REQUIRE(r.drive.run(init{}));
        other_client other{r.line, node<zlac8015d::device>{1}};
        using read = rows<zlac8015d::bus_voltage>;
        if (is_stepped) {
            stepped_write_then_read<other_client, read, zlac8015d::speed_resolution> call{other};
            REQUIRE(call.begin(checked(10)) == errc::ok);
            while (!call.done()) {
                const duration idle = call.step();
                r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
            CHECK(call.status().error() == errc::exception);
        } else {
            CHECK(other.write_then_read<read, zlac8015d::speed_resolution>(10).error() == errc::exception);
        }
        CHECK(r.drive.run(enable{}).error() == errc::needs_init);
    }
}

TEST_CASE(
    "G21: of a stepped write that first rules out an echo, the write counts and not the read before it") {
    simulated::closed_axis a;
    client axis{a.line, node<yako::closed_loop::device>{1}};
    stepped_write<decltype(axis), yako::pair_word_order> call{axis};
    REQUIRE(call.begin(checked(yako::word_order_setting::low_first)) == errc::ok);
    const auto events = [&] { return a.line.epoch(1).events.changes; };
    const auto before = events();
    while (a.requests.empty()) { // the read
        (void)call.step();
        a.wire.wait(microseconds(50));
        CHECK(events() == before);
    }
    while (!call.done()) {
        const duration idle = call.step();
        a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    REQUIRE(call.status());
    CHECK(a.model.peek(0x0019) == 1);
    CHECK(static_cast<std::uint8_t>(events() - before) == 1); // once
}

TEST_CASE("G21: a write to one drive of a line does not concern the others, but for several at once") {
    tests::wheels_and_lift world;
    line on{world.wire, modbus::timing_at(115200)};
    zlac8015d::drive wheels{on, 1, unsupervised};
    yako::closed_loop::drive lift{on, 2, unsupervised};
    client to_lift{on, node<yako::closed_loop::device>{2}};
    REQUIRE(wheels.run(init{}));
    REQUIRE(wheels.run(enable{}));
    REQUIRE(lift.run(init{}));
    const auto go = [&](i32 n) { return wheels.run(velocity{n * r_per_min, n * r_per_min}).error(); };
    for (i32 n = 1; n < 300; ++n) { // more than a counter of 8 bits has
        REQUIRE(to_lift.write<yako::microstep_resolution>(2000));
        REQUIRE(go(n % 30) == errc::ok);
    }
    CHECK(lift.run(yako::set_pv_trigger{yako::pv_trigger::level}).error() == errc::needs_init);
    REQUIRE(lift.run(init{}));
    CHECK(lift.cached().microsteps == 2000);
    // Two of them between two looks: which drives they were of is not known.
    REQUIRE(to_lift.write<yako::microstep_resolution>(1000));
    REQUIRE(to_lift.write<yako::microstep_resolution>(2000));
    CHECK(go(20) == errc::needs_init);
    REQUIRE(wheels.run(init{}));
    REQUIRE(wheels.run(enable{}));
    REQUIRE(lift.run(init{}));
    // To all.
    REQUIRE(to_lift.broadcast<yako::microstep_resolution>(1000));
    CHECK(go(20) == errc::needs_init);
    CHECK(lift.run(yako::set_pv_trigger{yako::pv_trigger::level}).error() == errc::needs_init);
}

TEST_CASE("G21, G36: on a bus, too, one drive is stale, and the values of the other are there after the next "
          "step") {
    tests::wheels_and_lift world;
    tests::wheels_and_lift_program p{world.wire};
    REQUIRE(p.command(p.wheels, init{}));
    REQUIRE(p.command(p.lift, init{}));
    p.run(300);
    REQUIRE(p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(200)));
    REQUIRE(p.all.latest<yako::closed_loop::output_polarity>(tests::lift_node, milliseconds(200)));
    client to_lift{p.on, tests::lift_node};
    status how = errc::busy;
    while (!how) {
        p.turn();
        how = to_lift.write<yako::microstep_resolution>(2000);
    }
    CHECK(p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(200)).error() ==
          errc::needs_init);
    const std::uint64_t written = world.wire.time_us();
    while (!p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(200)) &&
           world.wire.time_us() < written + 20'000)
        p.turn();
    CHECK(p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(200)));
    CHECK(p.all.latest<yako::closed_loop::output_polarity>(tests::lift_node, milliseconds(200)).error() ==
          errc::needs_init);
    CHECK(p.wheels.state() == drive_state::disabled);
    CHECK(p.lift.state() == drive_state::needs_init);
    p.run(300);
    CHECK(p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(200)));
    REQUIRE(p.command(p.lift, init{}));
    p.run(300);
    CHECK(p.all.latest<yako::closed_loop::output_polarity>(tests::lift_node, milliseconds(200)));
}

TEST_CASE("G21: what clients have learned of a node outlives writes that only a facade minds") {
    simulated::driven_c630s r;
    enabled_c630s::be_enabled_in(r, c630s::control_mode::speed);
    client direct{r.line, node<c630s::device>{1}};
    const auto token = direct.ram_only();
    REQUIRE(token);
    for (i32 n = 0; n < 3; ++n)
        REQUIRE(direct.write<c630s::max_forward_speed>(checked((3000 + n) * r_per_min), *token));
    const std::size_t frames = r.requests.size();
    CHECK(r.drive.run(velocity{100 * r_per_min}).error() == errc::needs_init);
    CHECK(r.requests.size() == frames);
    CHECK(r.model.peek(c630s::target_speed.address) == 0);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.cached().max_forward == 3002);

    simulated::closed_axis a;
    client axis{a.line, node<yako::closed_loop::device>{1}};
    REQUIRE(axis.learn_word_order());
    REQUIRE(axis.write<yako::microstep_resolution>(2000));
    CHECK(axis.read<yako::actual_position>());
}

TEST_CASE("G21: another facade of the drive that sets a cached row, or takes the drive over, is noticed") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    zlac8015d::drive other{r.line, 1, unsupervised};
    REQUIRE(other.run(init{}));
    REQUIRE(other.run(zlac8015d::set<zlac8015d::max_motor_speed>{500}));
    CHECK(other.state() == zlac8015d::drive_state::disabled); // its own command
    CHECK(other.cached().max_speed == 500);
    CHECK(r.drive.run(enable{}).error() == errc::needs_init);
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.cached().max_speed == 500);
    REQUIRE(r.drive.begin(zlac8015d::set<zlac8015d::max_motor_speed>{600}) == errc::ok);
    CHECK(other.run(enable{}).error() == errc::needs_init);
    while (!r.drive.is_idle()) {
        const duration idle = r.drive.step();
        r.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    CHECK(r.drive.last());
    CHECK(r.drive.cached().max_speed == 600);
    // What other commands of another facade change is read again by an enable, before it acts.
    REQUIRE(r.drive.run(init{}));
    REQUIRE(other.run(init{}));
    REQUIRE(other.run(zlac8015d::resolution{10}));
    CHECK(r.drive.run(enable{}).error() == errc::needs_init);
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("G21: an axis that moves is not stopped by a setting of another client") {
    simulated::closed_axis a;
    enabled_yako::take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    client other{a.line, node<yako::closed_loop::device>{1}};
    REQUIRE(other.write<yako::microstep_resolution>(1000));
    a.requests.clear();
    for (int i = 0; i < 2000; ++i) a.turn();
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.requests.empty());
    CHECK(a.is_moving());
}

} // namespace after_changed_settings_tests
