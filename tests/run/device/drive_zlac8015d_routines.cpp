// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D facade against its simulator: every routine of the manual's chapter 3 with the manual's own
// frames; parameters, resolutions, and values that are out of range.
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/enabled_zlac8015d.hpp>

namespace drive_zlac8015d_routines_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using enabled_zlac8015d::be_enabled_in;
using enabled_zlac8015d::fault_reset_frame;
using enabled_zlac8015d::quick_stop_frame;
using enabled_zlac8015d::stop_frame;
using rig = simulated::driven_zlac8015d;

namespace {

std::int64_t whole_rpm(std::int64_t micro) { return (micro + (micro < 0 ? -500'000 : 500'000)) / 1'000'000; }

} // namespace

TEST_CASE("3.1: velocity is set for both wheels in one frame, the manual's own, and for one wheel alone") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(ramps{500 * millisecond, 500 * millisecond}));
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    CHECK(r.sent(hex("01 10 20 88 00 02 04 00 64 00 64 23 9C")) == 1);
    REQUIRE(r.live(milliseconds(1500)));
    CHECK(whole_rpm(r.model.left().speed) == 100);
    CHECK(whole_rpm(r.model.right().speed) == 100);
    CHECK(r.drive.feedback(milliseconds(2000))->left_speed == 100 * r_per_min);
    REQUIRE(r.drive.run(left_velocity{-100 * r_per_min}));
    CHECK(r.sent(hex("01 06 20 88 FF 9C 43 B9")) == 1);
    REQUIRE(r.drive.run(right_velocity{-100 * r_per_min}));
    CHECK(r.sent(hex("01 06 20 89 FF 9C 12 79")) == 1);
    REQUIRE(r.live(milliseconds(2500)));
    CHECK(whole_rpm(r.model.left().speed) == -100);
    CHECK(whole_rpm(r.model.right().speed) == -100);
    REQUIRE(r.drive.run(halt{}));
    CHECK(r.model.stands_still());
    CHECK(r.model.enabled());
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.sent(stop_frame) == 2); // one by init
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
}

TEST_CASE("3.2: a synchronous relative move sends the manual's frames and ends at its target") {
    rig r;
    be_enabled_in(r, operating_mode::relative_position);
    REQUIRE(r.drive.run(position_speed{50 * r_per_min, 50 * r_per_min}));
    REQUIRE(r.drive.run(move_by{20480 * pulse, 20480 * pulse}));
    CHECK(r.sent(hex("01 10 20 8A 00 04 08 00 00 50 00 00 00 50 00 E3 2C")) == 1);
    CHECK(r.sent(hex("01 06 20 0E 00 10 E2 05")) == 1);
    CHECK(r.drive.run(move_by{1 * pulse, 1 * pulse}).error() == errc::busy);
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 20480);
    CHECK(r.model.right().position == 20480);
    REQUIRE(r.drive.run(move_by{-20480 * pulse, -20480 * pulse}));
    CHECK(r.sent(hex("01 10 20 8A 00 04 08 FF FF B0 00 FF FF B0 00 FC A3")) == 1);
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 0);
    CHECK(r.model.starts() == 2);
}

TEST_CASE("3.2: in an asynchronous move one wheel moves and the other stays at standstill") {
    rig r;
    be_enabled_in(r, operating_mode::relative_position, synchronisation::asynchronous);
    REQUIRE(r.drive.run(move_left_by{20480 * pulse}));
    CHECK(r.sent(hex("01 10 20 8A 00 02 04 00 00 50 00 DE 71")) == 1);
    CHECK(r.sent(hex("01 06 20 0E 00 11 23 C5")) == 1);
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 20480);
    CHECK(r.model.right().position == 0);
    REQUIRE(r.drive.run(move_right_by{-20480 * pulse}));
    CHECK(r.sent(hex("01 10 20 8C 00 02 04 FF FF B0 00 17 BF")) == 1);
    CHECK(r.sent(hex("01 06 20 0E 00 12 63 C4")) == 1);
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.right().position == -20480);
    CHECK(r.drive.run(move_by{1 * pulse, 1 * pulse}).error() == errc::wrong_state);
}

TEST_CASE("3.2: an absolute move reaches its target and returns; a target beyond 3FFFFFFFh is refused") {
    rig r;
    be_enabled_in(r, operating_mode::absolute_position);
    REQUIRE(r.drive.run(move_to{5000 * pulse, -3000 * pulse}));
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 5000);
    CHECK(r.model.right().position == -3000);
    REQUIRE(r.drive.run(move_to{0 * pulse, 0 * pulse}));
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 0);
    const auto frames = r.log.frames.size();
    CHECK(r.drive.run(move_to{0x40000000 * pulse, 0 * pulse}).error() == errc::out_of_range);
    CHECK(r.drive.run(move_by{1 * pulse, 1 * pulse}).error() == errc::wrong_state);
    CHECK(r.log.frames.size() == frames);
}

TEST_CASE("3.2: asynchronous absolute moves move one wheel at a time") {
    rig r;
    be_enabled_in(r, operating_mode::absolute_position, synchronisation::asynchronous);
    REQUIRE(r.drive.run(move_left_to{700 * pulse}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(move_right_to{-700 * pulse}));
    REQUIRE(r.drive.run(wait_standstill{}));
    CHECK(r.model.left().position == 700);
    CHECK(r.model.right().position == -700);
}

TEST_CASE("3.3: torque is set for both wheels or one with the manual's frames; a current out of range is "
          "refused") {
    rig r;
    be_enabled_in(r, operating_mode::torque);
    REQUIRE(r.drive.run(torque_slope{500 * milliampere_per_second}));
    REQUIRE(r.drive.run(torque{2000 * milliampere, 2000 * milliampere}));
    CHECK(r.sent(hex("01 10 20 90 00 02 04 07 D0 07 D0 60 23")) == 1);
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.left().current > 0);
    REQUIRE(r.drive.run(left_torque{-2 * ampere}));
    CHECK(r.sent(hex("01 06 20 90 F8 30 C1 F3")) == 1);
    REQUIRE(r.drive.run(right_torque{-2 * ampere}));
    CHECK(r.sent(hex("01 06 20 91 F8 30 90 33")) == 1);
    CHECK(r.drive.run(torque{31 * ampere, 0 * ampere}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.model.stands_still());
}

TEST_CASE("3.3: a halt in torque mode zeroes the torques and reads them back; a speed is neither written nor "
          "read") {
    rig r;
    be_enabled_in(r, operating_mode::torque);
    REQUIRE(r.drive.run(torque{3 * ampere, 3 * ampere}));
    REQUIRE(r.live(milliseconds(1000)));
    REQUIRE_FALSE(r.model.stands_still());
    r.log.frames.clear();
    REQUIRE(r.drive.run(halt{}));
    REQUIRE_FALSE(r.log.frames.empty());
    CHECK(same_bytes(r.log.frames[0], modbus::write_frame(1, 0x2090, std::array<std::uint16_t, 2>{0, 0})));
    CHECK(r.sent(modbus::read_frame(1, 0x2090, 2)) == 1);
    CHECK(r.model.stands_still());
    CHECK(r.model.enabled());
    CHECK(r.model.peek(0x2090) == 0);
    CHECK(r.model.peek(0x2091) == 0);
    for (const simulated::frame& f : r.log.frames) CHECK((f[2] != 0x20 || f[3] < 0x88 || f[3] > 0x8D));
}

TEST_CASE("3.3: torque mode: each command of another mode is refused, and each stop ends the torque") {
    const auto turns = [](rig& r) {
        be_enabled_in(r, operating_mode::torque);
        REQUIRE(r.drive.run(torque{3 * ampere, 3 * ampere}));
        REQUIRE(r.live(milliseconds(1000)));
        REQUIRE_FALSE(r.model.stands_still());
    };
    SUBCASE("commands of other modes") {
        rig r;
        turns(r);
        const std::size_t before = r.log.frames.size();
        CHECK(r.drive.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::wrong_state);
        CHECK(r.drive.begin(left_velocity{30 * r_per_min}) == errc::wrong_state);
        CHECK(r.drive.begin(right_velocity{30 * r_per_min}) == errc::wrong_state);
        CHECK(r.drive.begin(move_by{1000 * pulse, 1000 * pulse}) == errc::wrong_state);
        CHECK(r.log.frames.size() == before);
        CHECK(r.drive.run(enable_in{operating_mode::velocity}).error() ==
              errc::busy); // the mode is not changed
        CHECK(r.model.mode() == operating_mode::torque);
        REQUIRE(r.drive.run(left_torque{0 * ampere}));
        CHECK(r.model.peek(0x2090) == 0);
        CHECK(r.model.peek(0x2091) != 0);
    }
    SUBCASE("quick stop") {
        rig r;
        turns(r);
        REQUIRE(r.drive.run(quick_stop{}));
        CHECK(r.model.stands_still());
        CHECK(r.drive.begin(torque{1 * ampere, 1 * ampere}) == errc::wrong_state);
    }
    SUBCASE("disable") {
        rig r;
        turns(r);
        REQUIRE(r.drive.run(disable{}));
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        REQUIRE(r.drive.run(enable_in{operating_mode::torque})); // S2: with zero torques
        CHECK(r.model.peek(0x2090) == 0);
        CHECK(r.model.peek(0x2091) == 0);
        REQUIRE(r.live(milliseconds(500)));
        CHECK(r.model.stands_still());
    }
    SUBCASE("command timeout") {
        rig r;
        turns(r);
        r.drive.set_command_timeout(milliseconds(300));
        REQUIRE(r.drive.run(torque{3 * ampere, 3 * ampere}));
        for (const std::uint64_t end = r.wire.time_us() + 3'000'000; r.wire.time_us() < end;) {
            (void)r.drive.step();
            r.wire.pass(microseconds(500));
        }
        CHECK(r.model.peek(0x2090) == 0);
        CHECK(r.model.peek(0x2091) == 0);
        CHECK(r.model.stands_still());
    }
}

TEST_CASE("3.4: a quick stop holds both wheels until the next enable") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{200 * r_per_min, -200 * r_per_min}));
    REQUIRE(r.live(milliseconds(1500)));
    REQUIRE(r.drive.run(quick_stop{}));
    CHECK(r.sent(quick_stop_frame) == 1);
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::quick_stopped);
    CHECK(r.drive.run(velocity{1 * r_per_min, 1 * r_per_min}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.live(milliseconds(500)));
    CHECK(r.model.stands_still()); // the old targets are gone
}

TEST_CASE("3.5: a fault of one wheel stops both; a reset works only when the cause is gone and leaves the "
          "drive disabled") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    r.model.raise(fault::none, fault::overcurrent);
    const auto seen = r.drive.read();
    REQUIRE(seen);
    CHECK(seen->right_faults.has(fault::overcurrent));
    CHECK(r.sent(stop_frame) == 2);
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::faulted);
    CHECK(r.drive.cause() == stop_cause::fault);
    CHECK(r.drive.run(velocity{1 * r_per_min, 1 * r_per_min}).error() == errc::faulted);
    CHECK(r.drive.run(enable_in{operating_mode::velocity}).error() == errc::faulted);
    CHECK(r.drive.run(fault_reset{}).error() == errc::faulted);
    CHECK(r.sent(fault_reset_frame) == 1);
    r.model.end_faults();
    REQUIRE(r.drive.run(fault_reset{}));
    CHECK_FALSE(r.model.enabled());
    CHECK(r.drive.state() == drive_state::disabled);
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
}

TEST_CASE("3.6, 3.7: brakes, the action of a stop input and the quick stop option are set, and a stop input "
          "stops the drive") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(brakes{brake::code_1, brake::code_0}));
    CHECK(r.model.left().is_brake_engaged);
    CHECK_FALSE(r.model.right().is_brake_engaged);
    REQUIRE(r.drive.run(on_input_stop{input_stop_action::free_shaft}));
    CHECK(r.model.peek(0x2021) == 1);
    REQUIRE(r.drive.run(on_input_stop{input_stop_action::lock_shaft}));
    REQUIRE(r.drive.run(brakes{brake::code_0, brake::code_0}));
    REQUIRE(r.drive.run(quick_stop_by{quick_stop_option::fast_deceleration}));
    CHECK(r.model.peek(0x2011) == 6);
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}));
    REQUIRE(r.live(milliseconds(800)));
    r.model.set_input(true, false);
    REQUIRE(r.live(milliseconds(800)));
    CHECK(r.model.stands_still());
    CHECK(r.drive.state() == drive_state::quick_stopped);
    CHECK(r.drive.run(velocity{50 * r_per_min, 50 * r_per_min}).error() == errc::wrong_state);
}

TEST_CASE("ramps, parking, watchdog, position clearing, save and factory reset work in the states that allow "
          "them") {
    rig r;
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(ramps{700 * millisecond, 2 * second}));
    CHECK(r.model.peek(0x2080) == 700);
    CHECK(r.model.peek(0x2081) == 700);
    CHECK(r.model.peek(0x2082) == 2000);
    CHECK(r.model.peek(0x2083) == 2000);
    REQUIRE(r.drive.run(quick_stop_ramp{20 * millisecond}));
    CHECK(r.model.peek(0x2085) == 20);
    REQUIRE(r.drive.run(park{off_on::on}));
    CHECK(r.model.peek(0x200C) == 1);
    REQUIRE(r.drive.run(park{off_on::off}));
    REQUIRE(r.drive.run(watchdog{600 * millisecond}));
    CHECK(r.model.peek(0x2000) == 600);
    CHECK(r.drive.run(watchdog{0 * millisecond}).error() == errc::out_of_range);
    CHECK(r.drive.run(watchdog{33 * second}).error() == errc::out_of_range);
    REQUIRE(r.drive.run(save{}));
    CHECK(r.model.saves() == 1);
    REQUIRE(r.drive.run(enable_in{operating_mode::relative_position}));
    REQUIRE(r.drive.run(move_by{100 * pulse, 200 * pulse}));
    REQUIRE(r.drive.run(wait_standstill{}));
    REQUIRE(r.drive.run(clear_position{wheels::right}));
    REQUIRE(r.drive.read());
    CHECK(r.drive.feedback(milliseconds(2000))->left_position == 100 * count);
    CHECK(r.drive.feedback(milliseconds(2000))->right_position == 0 * count);
    REQUIRE(r.drive.run(clear_position{}));
    CHECK(r.drive.run(save{}).error() == errc::wrong_state); // enabled
    CHECK(r.drive.run(factory_reset{sole_drive_on_the_line{}}).error() == errc::wrong_state);
    REQUIRE(r.drive.run(disable{}));
    REQUIRE(r.drive.run(factory_reset{sole_drive_on_the_line{}}));
    CHECK(r.model.peek(0x2000) == 1000);
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("2022h scales commands: a speed is exact in every resolution, or refused") {
    for (std::uint16_t n = 1; n <= 10; ++n) {
        rig r;
        r.have_resolution(n);
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(resolution{n}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        REQUIRE(r.drive.run(velocity{60 * r_per_min, -60 * r_per_min}));
        CHECK(r.model.peek(0x2088) == 60 * n);
        REQUIRE(r.live(milliseconds(1500)));
        CHECK(whole_rpm(r.model.left().speed) == 60);
        CHECK(whole_rpm(r.model.right().speed) == -60);
        const command_status half = r.drive.run(velocity{5 * part<10>(r_per_min), 0 * r_per_min});
        CHECK(half.error() == (n % 2 == 0 ? errc::ok : errc::inexact));
        CHECK(r.drive.run(resolution{2}).error() == errc::wrong_state);
    }
    rig r;
    REQUIRE(r.drive.run(init{}));
    CHECK(r.drive.run(resolution{0}).error() == errc::out_of_range);
    CHECK(r.drive.run(resolution{11}).error() == errc::out_of_range);
}

TEST_CASE("a speed above 2008h is refused before anything is sent, for either wheel") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    const auto frames = r.log.frames.size();
    CHECK(r.drive.run(velocity{1001 * r_per_min, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{0 * r_per_min, -1001 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(velocity{2'000'000'000 * r_per_min, 0 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.log.frames.size() == frames);
    CHECK(r.drive.run(velocity{1000 * r_per_min, -1000 * r_per_min}));
}

TEST_CASE("before init, or with an invalid node address, nothing is sent") {
    rig r;
    CHECK(r.drive.run(enable{}).error() == errc::needs_init);
    CHECK(r.drive.run(velocity{1 * r_per_min, 1 * r_per_min}).error() == errc::needs_init);
    CHECK(r.drive.run(ramps{1 * second, 1 * second}).error() == errc::needs_init);
    CHECK(r.drive.run(brakes{brake::code_0, brake::code_0}).error() == errc::needs_init);
    CHECK(r.drive.read().error() == errc::needs_init);
    for (const unsigned address : {0u, 128u, 247u, 255u}) {
        zlac8015d::drive<rig::line_type> nobody{r.line, static_cast<std::uint8_t>(address), unsupervised};
        CHECK(nobody.run(init{}).error() == errc::bad_argument);
    }
    CHECK(r.log.frames.empty());
}

TEST_CASE("values outside their range are refused before anything is sent") {
    rig r;
    be_enabled_in(r, operating_mode::velocity);
    const auto frames = r.log.frames.size();
    CHECK(r.drive.run(ramps{33 * second, 1 * second}).error() == errc::out_of_range);
    CHECK(r.drive.run(ramps{1 * second, -1 * millisecond}).error() == errc::out_of_range);
    CHECK(r.drive.run(position_speed{0 * r_per_min, 1 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(position_speed{1 * r_per_min, 1001 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drive.run(position_speed{5 * part<10>(r_per_min), 1 * r_per_min}).error() == errc::inexact);
    CHECK(r.drive.run(torque_slope{70000 * milliampere_per_second}).error() == errc::out_of_range);
    CHECK(r.drive.run(torque{1 * ampere, 1 * ampere}).error() == errc::wrong_state);
    CHECK(r.log.frames.size() == frames);
}

} // namespace drive_zlac8015d_routines_tests
