// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade where the manual states nothing or can be read in two ways: under each interpretation each
// promise of machine safety holds, or a command fails and leaves the drive stopped. The tests check the
// frames on the wire and the simulated machine. The crash and the restart at every frame are in
// safety_zlac8015d.cpp.
#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/zlac8015d_interpretations.hpp>

namespace interpretations_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using simulated::are_slow;
using rig = simulated::driven_zlac8015d;
using simulated::zero_targets;
using zlac8015d_interpretations::options;

namespace {

constexpr auto stop_frame = modbus::write_frame(1, 0x200E, 0x07);
constexpr auto mode_0_frame = modbus::write_frame(1, 0x200D, 0);
constexpr auto save_frame = modbus::write_frame(1, 0x2010, 1);

std::size_t place_of(const rig& r, bytes wanted) {
    std::size_t i = 0;
    while (i < r.log.frames.size() && !same_bytes(r.log.frames[i], wanted)) ++i;
    return i;
}

void run_at_speed(rig& r) {
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(ramps{100 * millisecond, 100 * millisecond}));
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.run(velocity{90 * r_per_min, -90 * r_per_min}));
    REQUIRE(r.live(milliseconds(300)));
    REQUIRE_FALSE(are_slow(r.model));
}

} // namespace

TEST_CASE("S2: an enable is confirmed, or the drive is stopped and the command reports it" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const operating_mode mode :
             {operating_mode::velocity, operating_mode::torque, operating_mode::relative_position,
              operating_mode::absolute_position}) {
            CAPTURE(static_cast<int>(mode));
            rig r{of};
            REQUIRE(r.drive.run(init{}));
            const command_status got = r.drive.run(enable_in{checked(mode)});
            const bool can_know =
                mode != operating_mode::torque || of.in_torque_mode == options::shaft::locked;
            CHECK(static_cast<bool>(got) == can_know);
            CHECK(r.model.enabled() == can_know);
            if (!got) {
                CHECK(got.error() == errc::not_reached);
                CHECK(r.drive.state() == drive_state::needs_init);
                CHECK(r.sent(stop_frame) == 2); // one by init
                CHECK(r.drive.run(torque{1 * ampere, 1 * ampere}).error() == errc::needs_init);
            }
            ++scenes;
        }
        return scenes;
    });
}

TEST_CASE("S3: a turning drive is not mistaken for a restarted one, and a restart is detected" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const bool locks : {false, true}) {
            CAPTURE(locks);
            rig r{of};
            if (locks) r.set_by_hand(0x2007, 1);
            run_at_speed(r);
            REQUIRE(r.drive.run(disable{}));
            REQUIRE(r.drive.run(save{})); // after an enable, which has set a mode
            run_at_speed(r);
            REQUIRE(r.live(milliseconds(1500)));
            CHECK(r.drive.state() == drive_state::enabled);
            r.model.power_cycle();
            CHECK(r.model.peek(0x200D) == 0);
            for (int i = 0; i < 12 && r.drive.read(); ++i) r.wire.pass(milliseconds(50));
            CHECK(r.drive.state() == drive_state::needs_init);
            ++scenes;
        }
        return scenes;
    });
}

TEST_CASE("a save first writes mode 0, so that the mode shows a restart; it is refused while the drive is "
          "enabled" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        rig r{of};
        run_at_speed(r);
        const std::size_t frames = r.log.frames.size();
        CHECK(r.drive.run(save{}).error() == errc::wrong_state);
        CHECK(r.log.frames.size() == frames);
        REQUIRE(r.drive.run(disable{}));
        r.log.frames.clear();
        REQUIRE(r.drive.run(save{}));
        CHECK(r.sent(save_frame) == 1);
        CHECK(place_of(r, mode_0_frame) < place_of(r, save_frame));
        CHECK(r.model.saves() == r.saves + 1);
        r.model.power_cycle();
        CHECK(r.model.peek(0x200D) == 0);
        // While a wheel turns the mode is not changed, so nothing is saved.
        run_at_speed(r);
        REQUIRE(r.drive.run(disable{}));
        r.set_by_hand(0x200D, 3);
        r.set_by_hand(0x2088, 50);
        r.set_by_hand(0x200E, 8); // by another program
        r.wire.pass(milliseconds(100));
        r.log.frames.clear();
        CHECK_FALSE(r.drive.run(save{}));
        CHECK(r.sent(save_frame) == 0);
        return std::size_t{2};
    });
}

TEST_CASE("S3: after a fault of one wheel the next read stops both" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const bool is_left : {false, true}) {
            CAPTURE(is_left);
            rig r{of};
            run_at_speed(r);
            r.model.raise(is_left ? fault::overcurrent : fault::none,
                          is_left ? fault::none : fault::overcurrent);
            const bool goes_on = of.by_fault == options::switched_off::its_wheel;
            r.wire.pass(milliseconds(300));
            if (goes_on) CHECK_FALSE(are_slow(r.model));
            REQUIRE(r.drive.read());
            CHECK(are_slow(r.model));
            CHECK_FALSE(r.model.enabled());
            CHECK(r.drive.state() == drive_state::faulted);
            r.model.end_faults();
            const command_status reset = r.drive.run(fault_reset{});
            CHECK(static_cast<bool>(reset) == (of.code == options::fault_code::until_reset));
            if (!reset) CHECK(reset.error() == errc::faulted);
            if (!reset) CHECK(r.drive.run(enable{}).error() == errc::faulted);
            CHECK_FALSE(r.model.enabled());
            ++scenes;
        }
        return scenes;
    });
}

TEST_CASE("S3: after a long pause the first frame stops the drive, and nothing moves until an enable" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const bool halts : {false, true}) {
            rig r{of};
            run_at_speed(r);
            r.wire.pass(milliseconds(3000));
            REQUIRE(are_slow(r.model));
            const std::int64_t place = r.model.left().position;
            r.log.frames.clear();
            CHECK(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}).error() == errc::needs_init);
            CHECK(r.log.frames.empty());
            const command_status got = halts ? r.drive.run(halt{}) : r.drive.run(init{});
            REQUIRE(got);
            CHECK(same_bytes(r.log.frames[0], zero_targets));
            r.wire.pass(milliseconds(300));
            CHECK(r.model.left().position == place);
            ++scenes;
        }
        return scenes;
    });
}

TEST_CASE(
    "S3: a watchdog time of 0 in the drive is cached and never written; motion is bounded or does not occur" *
    doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        rig r{of};
        r.set_by_hand(0x2000, 0);
        const auto before = r.model.writes_to(0x2000);
        REQUIRE(r.drive.run(init{}));
        CHECK(r.drive.cached().host_timeout == 0);
        const command_status got = r.drive.run(enable_in{operating_mode::velocity});
        // A stopped drive that reports a locked shaft looks like an enabled one. It does not move either.
        const bool shows = of.after_quick_stop == options::stopped::emergency;
        CHECK(static_cast<bool>(got) == (of.host_timeout == options::zero::off || !shows));
        if (!got) {
            CHECK(got.error() == errc::not_reached);
            CHECK_FALSE(r.model.enabled());
        } else {
            (void)r.drive.run(velocity{60 * r_per_min, 60 * r_per_min});
            r.wire.pass(milliseconds(300));
            if (of.host_timeout == options::zero::stops) CHECK(r.model.stands_still());
            // The facade treats the watchdog time as one second.
            r.wire.pass(milliseconds(1000));
            CHECK(r.drive.run(velocity{10 * r_per_min, 10 * r_per_min}).error() == errc::needs_init);
            REQUIRE(r.drive.run(init{}));
            CHECK(are_slow(r.model));
        }
        CHECK(r.model.writes_to(0x2000) == before);
        return std::size_t{1};
    });
}

TEST_CASE("S5, B30: a restarted drive that shows an emergency stop without power is not taken for one that "
          "an input "
          "holds") {
    for (const options::idle shown : {options::idle::emergency, options::idle::released})
        for (const bool was_stopped : {false, true}) {
            options of;
            of.idle_shaft = shown;
            rig r{of};
            run_at_speed(r);
            if (was_stopped) REQUIRE(r.drive.run(quick_stop{}));
            CAPTURE(static_cast<int>(shown));
            CAPTURE(was_stopped);
            r.model.power_cycle();
            (void)r.drive.read();
            CHECK(r.drive.run(velocity{20 * r_per_min, 20 * r_per_min}).error() == errc::needs_init);
            CHECK(r.drive.state() == drive_state::needs_init);
            if (!was_stopped) CHECK(r.drive.cause() == stop_cause::restart); // the first cause counts
            CHECK(r.drive.run(enable{}).error() == errc::needs_init);        // the ramps are the factory's
            CHECK_FALSE(r.model.enabled());
        }
}

TEST_CASE("B30: a stop by an input is one, whatever a drive shows without power") {
    for (const options::idle shown : {options::idle::emergency, options::idle::released}) {
        options of;
        of.idle_shaft = shown;
        rig r{of};
        run_at_speed(r);
        r.model.set_input(true, false);
        REQUIRE(r.live(milliseconds(1500)));
        CHECK(r.drive.state() == drive_state::quick_stopped);
        CHECK(r.drive.cause() == stop_cause::input);
        r.model.set_input(false, false);
        CHECK(r.drive.run(enable{}));
        CHECK(r.model.enabled());
        CHECK(r.model.peek(0x2080) == 100); // its ramps
    }
}

} // namespace interpretations_zlac8015d_tests
