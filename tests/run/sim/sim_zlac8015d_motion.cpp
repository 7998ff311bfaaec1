// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The wheels of the simulated ZLAC8015D under velocity, position and torque control. A run does not depend on
// how often the clock advances.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>

#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_motion_tests {

using namespace servobus;
using namespace zlac8015d_bench;

// Velocity

TEST_CASE("B36: a linear ramp takes its time from 0, and ends at the target") {
    bench b{{.speed_ramp = sim::zlac8015d_options::ramp::linear}};
    CHECK(b.write(0x2080, {1000, 500, 250, 2000}) == 0);
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, -60}) == 0);
    b.run(500);
    CHECK(about(b.drive.left().speed, 50 * one_r_per_min, one_r_per_min));
    CHECK(about(b.drive.right().speed, -60 * one_r_per_min, one_r_per_min));
    b.run(501);
    CHECK(b.get(map::left_actual_speed) == 1000);
    CHECK(b.get(map::right_actual_speed) == -600);
    CHECK(b.status().left.is_running);
    CHECK(b.write(0x2088, {0, 60}) == 0); // the right wheel reverses: down in 2 s, up in 0.5 s
    b.run(251);
    CHECK(b.get(map::left_actual_speed) == 0);
    b.run(1000);
    CHECK(about(b.drive.right().speed, -60 * one_r_per_min * 749 / 2000, one_r_per_min));
    b.run(1252);
    CHECK(b.get(map::right_actual_speed) == 600);
    CHECK(!b.status().left.is_running);
}

TEST_CASE("B36: a ramp begins anew with each changed target, and takes its whole time") {
    bench b{{.speed_ramp = sim::zlac8015d_options::ramp::begins_anew}};
    CHECK(b.write(0x2080, {1000, 500, 250, 2000}) == 0);
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, -60}) == 0);
    b.run(2 + 250);
    CHECK(about(b.drive.left().speed, 100 * one_r_per_min * 106 / 1024,
                one_r_per_min)); // 10/64 - 15/256 + 6/1024
    CHECK(about(b.drive.right().speed, -30 * one_r_per_min, one_r_per_min));
    b.run(751);
    CHECK(b.get(map::left_actual_speed) == 1000);
    CHECK(b.get(map::right_actual_speed) == -600);
    CHECK(b.write(0x2088, {90, 60}) == 0); // the right wheel reverses, over the time to slow down
    b.run(2 + 125);
    CHECK(about(b.drive.left().speed, 95 * one_r_per_min, one_r_per_min));
    CHECK(b.write(0x2088, {90, 60}) == 0); // the same again changes nothing
    b.run(126);
    CHECK(b.get(map::left_actual_speed) == 900);
    b.run(1002 - 253);
    CHECK(about(b.drive.right().speed, 0, one_r_per_min));
    b.run(1001);
    CHECK(b.get(map::right_actual_speed) == 600);
    for (int i = 0; i < 50; ++i) { // a target every 20 ms is reached by no ramp of a second
        CHECK(b.write(0x2088, {static_cast<std::int16_t>(91 + i), 60}) == 0);
        b.run(20);
    }
    CHECK(b.get(map::left_actual_speed) < 910);
}

TEST_CASE("velocity: position is the integral of speed") {
    bench b;
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2080, {0, 0, 0, 0}) == 0);
    CHECK(b.write(0x2088, {60, -30}) == 0);
    b.run(10'000);
    CHECK(about(b.get(map::left_actual_position), 40'960, 2));
    CHECK(about(b.get(map::right_actual_position), -20'480, 2));
    b.set(map::left_encoder_lines, 512);
    const std::int32_t before = b.get(map::left_actual_position);
    b.run(10'000);
    CHECK(about(b.get(map::left_actual_position) - before, 20'480, 2));
}

TEST_CASE("velocity: 2022h rescales commanded speeds, and the actual ones stay in 0.1 r/min") {
    for (std::int64_t resolution = 1; resolution <= 10; ++resolution) {
        bench b;
        b.have_resolution(resolution);
        b.begin(operating_mode::velocity);
        b.set(map::left_target_speed, 300);
        b.run(600);
        CHECK(about(b.get(map::left_actual_speed), 3000 / resolution, 1));
        CHECK(b.drive.left().speed == 300 * one_r_per_min / resolution);
    }
}

TEST_CASE("velocity: a target above 2008h causes the fault speed_command on that axis and stops both "
          "wheels") {
    bench b;
    b.set(map::max_motor_speed, 100);
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, -100}) == 0);
    b.run(1000);
    CHECK(b.drive.enabled());
    b.set(map::right_target_speed, -101);
    CHECK(b.get(map::left_faults).bits == 0);
    CHECK(b.get(map::right_faults).bits == 0x2000);
    CHECK(b.status().right.shaft == shaft_state::alarm);
    CHECK(b.status().left.shaft == shaft_state::released);
    CHECK(!b.drive.enabled());
    b.run_until_still();
    b.command(control_code::fault_reset); // the cause is still present
    CHECK(b.get(map::right_faults).bits == 0x2000);
    b.set(map::right_target_speed, 0);
    b.command(control_code::fault_reset);
    CHECK(b.get(map::right_faults).bits == 0);
    CHECK(!b.drive.enabled());
    b.have_resolution(10);
    b.set(map::max_motor_speed, 100);
    b.begin(operating_mode::velocity);
    b.set(map::right_target_speed, 1000); // 100.0 r/min
    CHECK(b.drive.enabled());
}

// Position

TEST_CASE("position: a relative move ends exactly on its target and within the time of its trapezoid") {
    for (const std::int64_t distance : {1, -1, 2, 37, -500, 20480, -20480, 400'000, -1'234'567}) {
        for (const int speed : {1, 50, 1000}) {
            for (const int ramp : {0, 1, 500, 5000}) {
                if (std::llabs(distance) > 100'000 && speed == 1) continue;
                CAPTURE(distance);
                CAPTURE(speed);
                CAPTURE(ramp);
                bench b;
                CHECK(b.write(0x2080, {ramp, ramp, ramp, ramp}) == 0);
                CHECK(b.write(0x208E, {speed, speed}) == 0);
                b.begin(operating_mode::relative_position);
                b.set(map::left_target_position, distance);
                b.command(control_code::start_left);
                std::int64_t furthest = 0;
                std::uint32_t ms = 0;
                for (; ms < 1'000'000 && b.drive.left().is_moving; ++ms) {
                    b.run(1);
                    furthest = std::max<std::int64_t>(furthest, std::llabs(b.drive.left().position));
                }
                CHECK(b.get(map::left_actual_position) == distance);
                CHECK(b.drive.left().position == distance);
                CHECK(b.drive.stands_still());
                CHECK(furthest == std::llabs(distance));
                const std::int64_t cruise_ms = std::llabs(distance) * 60'000 / 4096 / speed;
                CHECK(ms <= cruise_ms * 11 / 10 + 2 * ramp + 20);
                CHECK(ms + 1 >= cruise_ms);
                CHECK(b.drive.starts() == 1);
            }
        }
    }
}

TEST_CASE("position: the speed stays within 208Eh/208Fh and 2008h") {
    bench b;
    b.set(map::right_max_speed, 80);
    b.set(map::max_motor_speed, 30);
    b.begin(operating_mode::relative_position);
    b.set(map::right_target_position, 20'480);
    b.command(control_code::start_right);
    std::int64_t fastest = 0;
    while (b.drive.right().is_moving) {
        b.run(1);
        fastest = std::max(fastest, b.drive.right().speed);
    }
    CHECK(fastest == 30 * one_r_per_min);
    CHECK(b.drive.left().position == 0);
}

TEST_CASE("B25: 10h, 11h and 12h start their wheels whatever 200Fh is, or 10h if it is 1 and the others if "
          "it is 0") {
    using start = sim::zlac8015d_options::start;
    for (const start which : {start::any, start::by_200F}) {
        for (const bool is_synchronous : {false, true}) {
            CAPTURE(is_synchronous);
            bench b{{.position_start = which}};
            const bool starts_both = which == start::any || is_synchronous;
            const bool starts_one = which == start::any || !is_synchronous;
            b.set(map::position_synchronisation, is_synchronous ? 1 : 0);
            b.begin(operating_mode::relative_position);
            CHECK(b.write(0x208A, {0, 1000, -1, -1000}) == 0);
            b.command(control_code::start_both);
            b.run(2000);
            CHECK(b.drive.left().position == (starts_both ? 1000 : 0));
            CHECK(b.drive.right().position == (starts_both ? -1000 : 0));
            b.command(control_code::start_right);
            b.run(2000);
            CHECK(b.drive.left().position == (starts_both ? 1000 : 0));
            CHECK(b.drive.right().position == (starts_both ? -1000 : 0) + (starts_one ? -1000 : 0));
            CHECK(b.drive.starts() == (starts_both ? 1 : 0) + (starts_one ? 1 : 0));
        }
    }
}

TEST_CASE("position: a target without a start moves nothing, nor does a start in another mode or while "
          "disabled") {
    bench b;
    b.mode(operating_mode::relative_position);
    b.set(map::left_target_position, 1000);
    b.command(control_code::start_left);
    b.command(control_code::enable);
    b.run(1000);
    CHECK(b.drive.left().position == 0);
    b.mode(operating_mode::torque);
    b.command(control_code::start_left);
    b.run(1000);
    CHECK(b.drive.left().position == 0);
    CHECK(b.drive.starts() == 0);
    CHECK(b.drive.commands(control_code::start_left) == 2);
}

TEST_CASE("position: a second relative start while moving adds to the target") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 4096);
    b.command(control_code::start_left);
    b.run(100);
    b.command(control_code::start_left);
    b.run_until_still();
    CHECK(b.drive.left().position == 8192);
    CHECK(b.drive.starts() == 2);
}

TEST_CASE("position: absolute moves refer to the origin, which 2006h sets; 2005h sets the feedback to zero") {
    bench b;
    b.begin(operating_mode::absolute_position);
    b.set(map::left_target_position, 1000);
    b.command(control_code::start_left);
    b.run_until_still();
    b.command(control_code::start_left); // already there
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 1000);
    b.set(map::clear_feedback_position, 1);
    CHECK(b.get(map::left_actual_position) == 0);
    CHECK(b.get(map::clear_feedback_position) == map::wheels::none);
    b.command(control_code::start_left);
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 0);
    b.set(map::clear_absolute_position, 3);
    b.command(control_code::start_left);
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 1000);
    b.set(map::left_target_position, 0x40000000);
    b.command(control_code::start_left);
    b.run(1000);
    CHECK(b.get(map::left_actual_position) == 1000);
}

TEST_CASE("position: a nearer absolute target during a move is overshot and then reached") {
    bench b;
    b.begin(operating_mode::absolute_position);
    b.set(map::left_max_speed, 500);
    b.set(map::left_target_position, 100'000);
    b.command(control_code::start_left);
    b.run(1000);
    const std::int64_t here = b.drive.left().position;
    b.set(map::left_target_position, here + 10);
    b.command(control_code::start_left);
    b.run(100);
    CHECK(b.drive.left().position > here + 10);
    b.run_until_still();
    CHECK(b.drive.left().position == here + 10);
}

TEST_CASE("position: a quick stop cancels the move, and an enable does not resume it") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 40'960);
    b.command(control_code::start_left);
    b.run(1000);
    b.command(control_code::quick_stop);
    b.run_until_still();
    const std::int64_t here = b.drive.left().position;
    b.command(control_code::enable);
    b.run(1000);
    CHECK(b.drive.left().position == here);
}

// Torque

TEST_CASE("torque: the current follows its slope, and the wheel accelerates to at most 2008h") {
    bench b;
    b.set(map::max_motor_speed, 200);
    b.set(map::left_torque_slope, 500);
    b.begin(operating_mode::torque);
    CHECK(b.write(0x2090, {2000, -100}) == 0);
    b.run(1000);
    CHECK(about(b.drive.left().current, 500'000, 2000));
    CHECK(b.get(map::left_actual_torque) == 5);
    CHECK(b.get(map::left_actual_speed) > 0);
    CHECK(b.get(map::right_actual_speed) == 0); // friction holds
    b.run(9000);
    CHECK(b.get(map::left_actual_torque) == 20);
    CHECK(b.get(map::left_actual_speed) == 2000);
    b.set(map::left_target_torque, 0);
    b.run_until_still();
    CHECK(b.drive.stands_still());
    b.set(map::left_max_current, 10);
    b.set(map::left_target_torque, -30000);
    b.set(map::left_torque_slope, 65535);
    b.run(1000);
    CHECK(b.get(map::left_actual_torque) == -10);
    CHECK(b.get(map::left_actual_speed) < 0);
    b.command(control_code::stop);
    b.run_until_still();
    b.run(1);
    CHECK(b.get(map::left_actual_torque) == 0);
}

// Time

TEST_CASE("a run is the same however often the clock advances") {
    const auto position_with = [](std::uint32_t step_us) {
        sim::zlac8015d drive;
        const auto put = [&](std::uint16_t address, std::uint16_t word) {
            const std::uint8_t raw[2] = {static_cast<std::uint8_t>(word >> 8),
                                         static_cast<std::uint8_t>(word & 0xFF)};
            CHECK(drive.write(address, words_view{raw}) == 0);
        };
        instant now{0};
        drive.advance(now);
        put(0x2000, 0);
        put(0x200D, 3);
        put(0x200E, 8);
        put(0x2088, 77);
        for (std::uint32_t t = 0; t < 3'000'000; t += step_us) {
            now = now + microseconds(step_us);
            drive.advance(now);
        }
        return drive.left().position;
    };
    const std::int64_t position = position_with(1'000'000);
    CHECK(position > 10'000);
    CHECK(position_with(100) == position);
    CHECK(position_with(3'000'000) == position);
}

namespace {
constexpr std::int64_t moved_at_compile_time() {
    sim::zlac8015d drive;
    const auto put = [&](std::uint16_t address, std::uint16_t word) {
        const std::array<std::uint8_t, 2> raw{static_cast<std::uint8_t>(word >> 8),
                                              static_cast<std::uint8_t>(word)};
        return drive.write(address, words_view{raw});
    };
    drive.advance(instant{0});
    put(0x200D, 1);
    put(0x2080, 0);
    put(0x2082, 0);
    put(0x208B, 20);
    put(0x200E, 8);
    put(0x200E, 0x11);
    drive.advance(instant{10'000}); // few ticks: compilers count their steps
    return drive.left().position;
}
static_assert(moved_at_compile_time() == 20);
} // namespace

} // namespace sim_zlac8015d_motion_tests
