// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The scenes of the ZLAC8015D's promises S1 to S3 that drive_zlac8015d_safety.cpp and bus_standstill.cpp play
// on the default simulated drive, here under each interpretation of its manual. Also S6 and S7, as far as a command
// can keep them.
#include <doctest/doctest.h>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/zlac8015d_interpretations.hpp>

namespace interpretations_zlac8015d_scenes_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using simulated::are_slow;
using simulated::is_motion_or_enable;
using rig = simulated::driven_zlac8015d;
using simulated::zero_targets;
using zlac8015d_interpretations::options;

namespace {

constexpr auto stop_frame = modbus::write_frame(1, 0x200E, 0x07);
constexpr auto start_frame = modbus::write_frame(1, 0x200E, 0x10);
constexpr operating_mode modes[] = {operating_mode::velocity, operating_mode::torque,
                                    operating_mode::relative_position, operating_mode::absolute_position};

bool can_enable(operating_mode mode, const options& of) {
    return mode != operating_mode::torque || of.in_torque_mode == options::shaft::locked;
}
bool can_move(const options& of) { return of.bit != options::running::enabled; }

// Leaves the wheels turning, as another program does that has crashed, with the factory's ramps of 500 ms.
void leave_running(rig& r, operating_mode mode) {
    r.wire.pass(milliseconds(1)); // sets the drive's clock
    r.set_by_hand(0x200D, static_cast<u16>(mode));
    r.set_by_hand(0x200F, 1);
    r.set_by_hand(0x2086, 30'000);
    r.set_by_hand(0x2087, 30'000);
    r.set_by_hand(0x200E, 8);
    if (mode == operating_mode::velocity) {
        r.set_by_hand(0x2088, 300);
        r.set_by_hand(0x2089, static_cast<u16>(-300));
    } else if (mode == operating_mode::torque) {
        r.set_by_hand(0x2090, 3000);
        r.set_by_hand(0x2091, 3000);
    } else {
        r.set_by_hand(0x208A, 1); // 65536 counts
        r.set_by_hand(0x208C, 1);
        r.set_by_hand(0x200E, 0x10);
    }
    r.wire.pass(milliseconds(700));
    REQUIRE_FALSE(are_slow(r.model));
}

} // namespace

TEST_CASE("S1: in any mode init stops the motion that a crashed program left, and waits for standstill" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const operating_mode mode : modes) {
            CAPTURE(static_cast<int>(mode));
            for (const u16 option : {u16{0}, u16{1}}) { // 2013h: 07h releases the shafts, or slows down
                rig r{of};
                r.set_by_hand(0x2013, option);
                leave_running(r, mode);
                r.log.frames.clear();
                REQUIRE(r.drive.run(init{}));
                CHECK(same_bytes(r.log.frames[0], zero_targets));
                CHECK(same_bytes(r.log.frames[1], stop_frame));
                for (const auto& f : r.log.frames) CHECK_FALSE(is_motion_or_enable(f));
                CHECK(are_slow(r.model));
                CHECK_FALSE(r.model.enabled());
                CHECK(r.drive.state() == drive_state::disabled);
                ++scenes;
            }
        }
        return scenes;
    });
}

TEST_CASE("S2: before every enable old targets are set to zero and read back, and they move nothing" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (const operating_mode mode : modes) {
            CAPTURE(static_cast<int>(mode));
            for (const bool were_saved : {false, true}) {
                rig r{of};
                r.set_by_hand(0x2088, 500);
                r.set_by_hand(0x2091, 2000);
                r.set_by_hand(0x208B, 10'000);
                r.set_by_hand(0x200D, 3);
                if (were_saved) {
                    r.save_by_hand();
                    r.model.power_cycle();
                }
                REQUIRE(r.drive.run(init{}));
                CHECK(static_cast<bool>(r.drive.run(enable_in{checked(mode)})) == can_enable(mode, of));
                if (can_enable(mode, of)) REQUIRE(r.live(milliseconds(700)));
                CHECK(r.model.stands_still());
                CHECK(r.model.left().position == 0);
                CHECK(r.model.right().position == 0);
                CHECK(r.sent(modbus::read_frame(1, 0x2088, 2)) == 1);
                ++scenes;
            }
        }
        return scenes;
    });
}

TEST_CASE("S3: the mode changes only at standstill" * doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        rig r{of};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        REQUIRE(r.live(milliseconds(500)));
        r.log.frames.clear();
        CHECK(r.drive.run(enable_in{operating_mode::relative_position}).error() == errc::busy);
        CHECK(r.sent(modbus::write_frame(1, 0x200D, 1)) == 0);
        CHECK(r.model.mode() == operating_mode::velocity);
        return std::size_t{1};
    });
}

TEST_CASE("S3: a relative move is made at most once, whichever frame is lost" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        unsigned struck = 0;
        for (std::uint32_t lost = 0; lost < 8; ++lost) {
            for (const bool is_response : {false, true}) {
                rig r{of};
                REQUIRE(r.drive.run(init{}));
                REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
                const std::uint32_t first = r.wire.requests();
                REQUIRE(r.drive.begin(move_by{4096 * pulse, 4096 * pulse}) == errc::ok);
                while (!r.drive.is_idle()) {
                    const bool is_now = r.wire.requests() == first + lost + (is_response ? 1 : 0);
                    r.wire.faults().lost_request = is_now && !is_response ? 1000 : 0;
                    r.wire.faults().lost_response = is_now && is_response ? 1000 : 0;
                    const duration idle = r.drive.step();
                    r.wire.wait(idle.us < 100 ? microseconds(20) : microseconds(50));
                }
                r.wire.faults() = {};
                struck += r.wire.struck() != 0 ? 1u : 0u;
                CHECK(r.sent(start_frame) <= 1);
                if (!can_move(of)) CHECK(r.sent(start_frame) == 0);
                r.wire.pass(milliseconds(900));
                CHECK(r.model.starts() <= 1);
                if (r.drive.motion() == motion_check::seen && of.bit == options::running::turns)
                    CHECK(r.model.starts() == 1);
                ++scenes;
            }
        }
        CHECK(struck >= 4);
        return scenes;
    });
}

TEST_CASE(
    "S2: under each interpretation an old torque target has no effect when the mode of an enabled drive "
    "changes" *
    doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        rig r{of};
        REQUIRE(r.drive.run(init{}));
        if (!r.drive.run(enable_in{operating_mode::torque})) return std::size_t{1};
        const bool engages = of.code_1 == options::brake::engages;
        const brake held = engages ? brake::code_1 : brake::code_0;
        const brake released = engages ? brake::code_0 : brake::code_1;
        REQUIRE(r.drive.run(torque_slope{30'000 * milliampere_per_second}));
        REQUIRE(r.drive.run(brakes{held, held}));
        REQUIRE(r.drive.run(torque{8 * ampere, 8 * ampere}));
        const command_status changed = r.drive.run(enable_in{operating_mode::velocity});
        REQUIRE(static_cast<bool>(changed) == can_move(of)); // refused, if the bit is 1 while enabled
        if (!changed) CHECK(changed.error() == errc::busy);
        if (!changed) return std::size_t{1};
        REQUIRE(r.drive.run(brakes{released, released}));
        const std::int64_t left = r.model.left().position;
        REQUIRE(r.drive.run(enable_in{operating_mode::torque}));
        REQUIRE(r.live(milliseconds(500)));
        CHECK(r.model.left().position - left < 3);
        CHECK(r.model.left().position - left > -3);
        return std::size_t{1};
    });
}

TEST_CASE("S3: no read of a bus lets wheels go on that the watchdog has stopped" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        std::size_t scenes = 0;
        for (unsigned turns = 0; turns < 60; turns += 5) {
            CAPTURE(turns);
            tests::wheels_and_lift machine{of};
            tests::wheels_and_lift_program p{machine.wire};
            if (of.code_1 == options::brake::releases) {
                client direct{p.on, tests::wheels_node};
                REQUIRE(direct.write<left_brake>(brake::code_1));
                REQUIRE(direct.write<right_brake>(brake::code_1));
            }
            REQUIRE(p.command(p.wheels, init{}));
            REQUIRE(p.command(p.wheels, enable_in{operating_mode::velocity}));
            REQUIRE(p.command(p.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
            p.run(300);
            REQUIRE_FALSE(are_slow(machine.wheels_model));
            for (unsigned i = 0; i < turns; ++i) p.turn();
            machine.wire.pass(milliseconds(4000));
            REQUIRE(machine.wheels_model.stands_still());
            const std::int64_t place = machine.wheels_model.left().position;
            p.run(300);
            CHECK(machine.wheels_model.left().position == place);
            CHECK(p.wheels.state() == drive_state::needs_init);
            ++scenes;
        }
        return scenes;
    });
}

TEST_CASE("S6, S7: a factory reset and a save are refused while the drive is enabled, and nothing is "
          "written" *
          doctest::test_suite("interpretations")) {
    zlac8015d_interpretations::under([](const options& of) {
        rig r{of};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        const std::uint32_t writes = r.model.writes();
        CHECK(r.drive.run(factory_reset{sole_drive_on_the_line{}}).error() == errc::wrong_state);
        CHECK(r.drive.run(save{}).error() == errc::wrong_state);
        CHECK(r.drive.run(resolution{2}).error() == errc::wrong_state);
        CHECK(r.model.writes() == writes);
        return std::size_t{1};
    });
}

} // namespace interpretations_zlac8015d_scenes_tests
