// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated ZLAC8015D and the virtual line: that they behave as documented, so that tests of programs may
// lean on them.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/zlac8015d_bench.hpp>

using namespace servobus;
using namespace zlac8015d_bench;

// Registers

TEST_CASE("a new drive has every register of the catalogue at its default") {
    bench b;
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        std::array<std::uint16_t, 2> words{};
        REQUIRE(b.drive.read(e.address, std::span<std::uint16_t>{words}.first(e.words())) == 0);
        if (e.rights == access::ro || e.initial == no_default) continue;
        const std::uint32_t bits =
            e.words() == 2 ? join_words(words[0], words[1], word_order::high_first) : words[0];
        CHECK(e.number(bits) == e.initial);
    }
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 115200);
}

TEST_CASE("an address that does not exist is exception 2, alone and inside a block") {
    bench b;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const auto at = static_cast<std::uint16_t>(address);
        const bool exists = map::catalogue.find(at) != nullptr;
        std::array<std::uint16_t, 1> word{};
        if (b.drive.read(at, word) != (exists ? 0 : 2)) FAIL_CHECK("read of " << address);
        if (!exists && b.write(at, 0) != 2) FAIL_CHECK("write to " << address);
    }
    std::array<std::uint16_t, 8> words{};
    CHECK(b.drive.read(0x2010, words) == 2); // 2015h is a gap
    CHECK(b.drive.read(0x20AF, std::span<std::uint16_t>{words}.first(3)) == 2);
    CHECK(b.drive.read(0x2088, words) == 0);
}

TEST_CASE(
    "values at the ends of their range are taken, those beyond are exception 3, read-only rows exception 2") {
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        bench b;
        const auto put = [&](std::int64_t v) {
            return e.words() == 2 ? b.write(e.address, {v >> 16, v & 0xFFFF}) : b.write(e.address, v);
        };
        if (e.rights == access::ro) {
            CHECK(put(0) == 2);
            continue;
        }
        CHECK(put(e.limits.low) == 0);
        CHECK(put(e.limits.high) == 0);
        const bool is_packed_full = !e.limits.is_stated;
        if (is_packed_full) continue;
        CHECK(put(e.limits.high + 1) == 3);
        CHECK(put(e.limits.low - 1) == 3);
    }
}

TEST_CASE("only the control word's own codes are taken") {
    for (unsigned code = 0; code <= 0x13; ++code) {
        bench b;
        const bool is_code = code == 0 || (code >= 5 && code <= 8) || (code >= 0x10 && code <= 0x12);
        CHECK(b.write(0x200E, code) == (is_code ? 0 : 3));
    }
}

TEST_CASE("G14: a write of several registers is all or nothing") {
    bench b;
    CHECK(b.write(0x2080, {100, 200, 40000}) == 3);
    CHECK(b.write(0x2013, {0, 1, 0}) == 2); // 2015h is a gap
    CHECK(b.write(0x2091, {1000, 0}) == 2); // 2092h does not exist
    CHECK(b.get(map::left_acceleration_time) == 500);
    CHECK(b.get(map::right_target_torque) == 0);
    CHECK(b.drive.writes() == 0);
    CHECK(b.write(0x2080, {100, 200, 300}) == 0);
    CHECK(b.get(map::left_deceleration_time) == 300);
}

TEST_CASE("a 32-bit value may be written word by word") {
    bench b;
    CHECK(b.write(0x208A, -1) == 0);
    CHECK(b.write(0x208B, -5) == 0);
    CHECK(b.get(map::left_target_position) == -5);
    CHECK(b.write(0x208A, {0x8000, 0}) == 3);
}

TEST_CASE("writes are counted by register and logged in order") {
    bench b;
    b.order(command::stop);
    CHECK(b.write(0x2088, {1, 2}) == 0);
    CHECK(b.drive.writes_to(0x2088) == 1);
    CHECK(b.drive.writes_to(0x1234) == 0);
    CHECK(b.drive.orders(command::stop) == 1);
    CHECK(b.drive.last_write(0).address == 0x2089);
    CHECK(b.drive.last_write(2).address == 0x200E);
    CHECK(b.drive.last_write(2).value == 7);
    CHECK(b.drive.last_write(3).ordinal == 0);
    for (int i = 0; i < 200; ++i) b.set(map::left_target_speed, i);
    CHECK(b.drive.last_write(63).value == 136);
    CHECK(b.drive.last_write(64).ordinal == 0);
}

// States

TEST_CASE("the drive is enabled only with a mode, and without a mode nothing tells but the status") {
    bench b;
    b.order(command::enable);
    CHECK(!b.drive.enabled());
    CHECK(b.status().left.shaft == shaft_state::released);
    b.begin(operating_mode::velocity);
    CHECK(b.get(map::status_word).to_word() == map::status::both_locked);
    CHECK(b.drive.enables() == 1);
    b.order(command::enable);
    CHECK(b.drive.enables() == 1);
}

TEST_CASE("S2: enable moves the wheels at once if the targets are not zero") {
    bench b;
    b.mode(operating_mode::velocity);
    b.set(map::left_target_speed, 50);
    b.run(100);
    CHECK(b.drive.stands_still());
    b.order(command::enable);
    b.run(100);
    CHECK(!b.drive.stands_still());
}

TEST_CASE("S3: the mode changes only while both wheels stand") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::right_target_speed, 20);
    b.run(50);
    b.mode(operating_mode::torque); // acknowledged
    CHECK(b.get(map::mode_of_operation) == operating_mode::velocity);
    b.set(map::right_target_speed, 0);
    b.run_until_still();
    b.mode(operating_mode::torque);
    CHECK(b.get(map::mode_of_operation) == operating_mode::torque);
    CHECK(b.drive.enabled());
    b.mode(operating_mode::undefined);
    CHECK(!b.drive.enabled());
}

TEST_CASE("stop slows down and releases the shafts, or releases them at once") {
    for (const bool ramps : {true, false}) {
        bench b;
        b.set(map::disable_option_code, ramps ? 1 : 0);
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, -100}) == 0);
        b.run(1000);
        b.order(command::stop);
        CHECK(!b.drive.enabled());
        b.run(400);
        CHECK(!b.drive.stands_still());
        if (ramps) CHECK(about(b.drive.left().speed, 20 * one_r_per_min, one_r_per_min));
        const std::uint32_t rest = b.run_until_still();
        CHECK((ramps ? rest < 105 : rest > 300));
        CHECK(b.get(map::status_word).to_word() == 0);
    }
}

TEST_CASE("quick stop follows its option, holds the shafts and lasts until the next enable") {
    struct {
        int option;
        std::uint32_t shortest, longest;
    } const cases[] = {{5, 480, 510}, {6, 10, 14}, {7, 1, 2}};
    for (const auto& c : cases) {
        CAPTURE(c.option);
        bench b;
        b.set(map::quick_stop_option_code, c.option);
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {200, 100}) == 0);
        b.run(1000);
        b.order(command::quick_stop);
        const std::uint32_t took = b.run_until_still();
        CHECK(took >= c.shortest);
        CHECK(took <= c.longest);
        CHECK(b.get(map::status_word).to_word() == map::status::both_stopped_in_emergency);
        b.run(500);
        b.set(map::left_target_speed, 10);
        b.order(command::start_left);
        b.run(500);
        CHECK(b.drive.stands_still());
        b.order(command::enable);
        b.run(100);
        CHECK(!b.drive.stands_still());
    }
}

TEST_CASE("quick stop of a drive that is not enabled changes nothing; stop leaves a quick stop") {
    bench b;
    b.order(command::quick_stop);
    CHECK(b.get(map::status_word).to_word() == 0);
    b.begin(operating_mode::velocity);
    b.order(command::quick_stop);
    CHECK(b.status().left.shaft == shaft_state::emergency_stop);
    b.order(command::stop);
    b.run(2);
    CHECK(b.get(map::status_word).to_word() == 0);
}

// Velocity

TEST_CASE("velocity: the ramps take their times and end on the target") {
    bench b;
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
    CHECK(b.write(0x2088, {0, 60}) == 0); // the right wheel turns: down in 2 s, up in 0.5 s
    b.run(251);
    CHECK(b.get(map::left_actual_speed) == 0);
    b.run(1000);
    CHECK(about(b.drive.right().speed, -60 * one_r_per_min * 749 / 2000, one_r_per_min));
    b.run(1252);
    CHECK(b.get(map::right_actual_speed) == 600);
    CHECK(!b.status().left.is_running);
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

TEST_CASE("velocity: 2022h rescales commanded speeds and leaves the actual ones in 0.1 r/min") {
    for (std::int64_t resolution = 1; resolution <= 10; ++resolution) {
        bench b;
        b.set(map::speed_resolution, resolution);
        b.begin(operating_mode::velocity);
        b.set(map::left_target_speed, 300);
        b.run(600);
        CHECK(about(b.get(map::left_actual_speed), 3000 / resolution, 1));
        CHECK(b.drive.left().speed == 300 * one_r_per_min / resolution);
    }
}

TEST_CASE("velocity: a target above 2008h is the fault speed_command on that axis, and stops both wheels") {
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
    b.order(command::fault_reset); // the cause still stands
    CHECK(b.get(map::right_faults).bits == 0x2000);
    b.set(map::right_target_speed, 0);
    b.order(command::fault_reset);
    CHECK(b.get(map::right_faults).bits == 0);
    CHECK(!b.drive.enabled());
    b.set(map::speed_resolution, 10);
    b.set(map::right_target_speed, 1000); // 100.0 r/min
    b.order(command::enable);
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
                b.order(command::start_left);
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
    b.order(command::start_right);
    std::int64_t fastest = 0;
    while (b.drive.right().is_moving) {
        b.run(1);
        fastest = std::max(fastest, b.drive.right().speed);
    }
    CHECK(fastest == 30 * one_r_per_min);
    CHECK(b.drive.left().position == 0);
}

TEST_CASE("position: 10h starts both wheels if 200Fh = 1, 11h and 12h one each if it is 0") {
    for (const bool is_synchronous : {false, true}) {
        bench b;
        b.set(map::position_synchronisation, is_synchronous ? 1 : 0);
        b.begin(operating_mode::relative_position);
        CHECK(b.write(0x208A, {0, 1000, -1, -1000}) == 0);
        b.order(command::start_both);
        b.run(2000);
        CHECK(b.drive.left().position == (is_synchronous ? 1000 : 0));
        CHECK(b.drive.right().position == (is_synchronous ? -1000 : 0));
        b.order(command::start_right);
        b.run(2000);
        CHECK(b.drive.right().position == -1000);
        CHECK(b.drive.starts() == 1);
        CHECK(b.drive.left().starts == (is_synchronous ? 1 : 0));
    }
}

TEST_CASE("position: a target alone moves nothing, nor does a start in another mode or while disabled") {
    bench b;
    b.mode(operating_mode::relative_position);
    b.set(map::left_target_position, 1000);
    b.order(command::start_left);
    b.order(command::enable);
    b.run(1000);
    CHECK(b.drive.left().position == 0);
    b.mode(operating_mode::torque);
    b.order(command::start_left);
    b.run(1000);
    CHECK(b.drive.left().position == 0);
    CHECK(b.drive.starts() == 0);
    CHECK(b.drive.orders(command::start_left) == 2);
}

TEST_CASE("position: a second relative start while moving adds to the target") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 4096);
    b.order(command::start_left);
    b.run(100);
    b.order(command::start_left);
    b.run_until_still();
    CHECK(b.drive.left().position == 8192);
    CHECK(b.drive.starts() == 2);
}

TEST_CASE("position: absolute moves count from the origin, which 2006h sets; 2005h sets the feedback") {
    bench b;
    b.begin(operating_mode::absolute_position);
    b.set(map::left_target_position, 1000);
    b.order(command::start_left);
    b.run_until_still();
    b.order(command::start_left); // already there
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 1000);
    b.set(map::clear_feedback_position, 1);
    CHECK(b.get(map::left_actual_position) == 0);
    CHECK(b.get(map::clear_feedback_position) == map::wheels::none);
    b.order(command::start_left);
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 0);
    b.set(map::clear_absolute_position, 3);
    b.order(command::start_left);
    b.run_until_still();
    CHECK(b.get(map::left_actual_position) == 1000);
    b.set(map::left_target_position, 0x40000000);
    b.order(command::start_left);
    b.run(1000);
    CHECK(b.get(map::left_actual_position) == 1000);
}

TEST_CASE("position: a nearer absolute target while moving is overshot and reached") {
    bench b;
    b.begin(operating_mode::absolute_position);
    b.set(map::left_max_speed, 500);
    b.set(map::left_target_position, 100'000);
    b.order(command::start_left);
    b.run(1000);
    const std::int64_t here = b.drive.left().position;
    b.set(map::left_target_position, here + 10);
    b.order(command::start_left);
    b.run(100);
    CHECK(b.drive.left().position > here + 10);
    b.run_until_still();
    CHECK(b.drive.left().position == here + 10);
}

TEST_CASE("position: a quick stop drops the move, and enable does not take it up again") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 40'960);
    b.order(command::start_left);
    b.run(1000);
    b.order(command::quick_stop);
    b.run_until_still();
    const std::int64_t here = b.drive.left().position;
    b.order(command::enable);
    b.run(1000);
    CHECK(b.drive.left().position == here);
}

// Torque

TEST_CASE("torque: the current follows its slope, the wheel speeds up to at most 2008h") {
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
    b.order(command::stop);
    b.run_until_still();
    b.run(1);
    CHECK(b.get(map::left_actual_torque) == 0);
}

// Watchdog

TEST_CASE("G19: silence for longer than 2000h stops both wheels, not earlier") {
    bench b;
    b.set(map::host_timeout, 200);
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, 100}) == 0);
    b.run(1000);
    b.silent(200);
    CHECK(!b.drive.in_watchdog_stop());
    b.silent(1);
    CHECK(b.drive.in_watchdog_stop());
    b.silent(505);
    CHECK(b.drive.stands_still());
    CHECK(map::status::from_word(b.drive.peek(0x20A2)).left.shaft == shaft_state::emergency_stop);
}

TEST_CASE("S3: after a watchdog stop the targets stand, and any request lets the wheels go on") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.silent(3000);
    CHECK(b.drive.stands_still());
    CHECK(b.get(map::bus_voltage) == 2400); // a mere read
    CHECK(!b.drive.in_watchdog_stop());
    b.run(600);
    CHECK(b.get(map::left_actual_speed) == 1000);
    b.silent(3000);
    CHECK(b.write(0x2088, {0, 0}) == 0); // the right first frame
    const std::int64_t here = b.drive.left().position;
    b.run(1000);
    CHECK(b.drive.left().position == here);
}

TEST_CASE("S3: a position move goes on after a watchdog stop too") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 20'480);
    b.order(command::start_left);
    b.run(500);
    b.silent(5000);
    CHECK(b.drive.left().position < 20'480);
    b.run_until_still();
    CHECK(b.drive.left().position == 20'480);
    CHECK(b.drive.starts() == 1);
}

TEST_CASE("S3: the other drive that the manual allows stays in quick stop after a watchdog stop") {
    bench b{{.resumes_after_watchdog = false}};
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.silent(3000);
    b.run(1000);
    CHECK(b.drive.stands_still());
    CHECK(b.drive.in_watchdog_stop());
    CHECK(b.get(map::status_word).to_word() == map::status::both_stopped_in_emergency);
    b.order(command::enable);
    b.run(1000);
    CHECK(!b.drive.in_watchdog_stop());
    CHECK(b.get(map::left_actual_speed) == 1000);
}

TEST_CASE("a watchdog time of 0 switches the watchdog off, or an enabled drive stops immediately") {
    bench other{{.host_timeout = sim::zlac8015d_options::zero::stops}};
    other.set(map::host_timeout, 0);
    other.begin(operating_mode::velocity);
    other.set(map::left_target_speed, 10);
    other.run(1000);
    CHECK(other.drive.stands_still());
    CHECK(other.drive.left().position == 0);
    bench b;
    b.set(map::host_timeout, 0);
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 10);
    b.silent(60'000);
    CHECK(!b.drive.stands_still());
}

// Faults, inputs, brakes

TEST_CASE("S3: one wheel's fault stops both, and is cleared only when its cause is gone") {
    bench b;
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, 100}) == 0);
    b.run(1000);
    b.drive.raise(fault::overcurrent, fault::none);
    CHECK(!b.drive.enabled());
    CHECK(b.status().left.shaft == shaft_state::alarm);
    CHECK(b.get(map::left_faults).has(fault::overcurrent));
    b.run_until_still();
    b.order(command::enable);
    CHECK(!b.drive.enabled());
    b.order(command::fault_reset);
    CHECK(b.get(map::left_faults).any());
    b.drive.end_faults();
    CHECK(b.get(map::left_faults).any());
    b.order(command::enable);
    CHECK(!b.drive.enabled());
    b.order(command::fault_reset);
    CHECK(!b.get(map::left_faults).any());
    CHECK(!b.drive.enabled());
    b.order(command::enable);
    CHECK(b.drive.enabled());
}

TEST_CASE("with 201Fh = 1 the wheels brake after a fault, with 0 they roll out") {
    std::uint32_t took[2] = {};
    for (const int shorted : {0, 1}) {
        bench b;
        b.set(map::pwm_on_alarm, shorted);
        b.begin(operating_mode::velocity);
        b.set(map::right_target_speed, 100);
        b.run(1000);
        b.drive.raise(fault::hall, fault::none);
        CHECK((b.drive.peek(0x20A3) >> 8) == 0);
        took[shorted] = b.run_until_still();
    }
    CHECK(took[0] > 1000);
    CHECK(took[1] < 300);
}

TEST_CASE("a motor above its limit has the fault motor_overtemperature") {
    bench b;
    b.begin(operating_mode::velocity);
    b.drive.set_motor_temperature(-20, 80);
    CHECK(b.drive.enabled());
    b.drive.set_motor_temperature(-20, 81);
    CHECK(b.get(map::right_faults).has(fault::motor_overtemperature));
    CHECK(b.get(map::motor_temperature).left == -20);
    CHECK(b.get(map::motor_temperature).right == 81);
}

TEST_CASE("the stop input does a quick stop as 2011h and 2021h say, and honours function and polarity") {
    for (const bool inverted : {false, true}) {
        for (const int release : {0, 1}) {
            for (const int option : {5, 6, 7}) {
                CAPTURE(inverted);
                CAPTURE(release);
                CAPTURE(option);
                bench b;
                b.drive.set_input(inverted, inverted);
                b.set(map::input_polarity, inverted ? 1 : 0);
                b.set(map::input_stop, release);
                b.set(map::quick_stop_option_code, option);
                b.begin(operating_mode::velocity);
                b.set(map::left_target_speed, 100);
                b.run(1000);
                b.drive.set_input(inverted, !inverted); // X1 has no function
                b.run(100);
                CHECK(b.drive.enabled());
                b.drive.set_input(!inverted, inverted);
                b.run(1);
                CHECK(b.drive.current_state() == sim::zlac8015d::state::quick_stop);
                CHECK(b.get(map::input_state).x0 == !inverted);
                const std::uint32_t took = b.run_until_still();
                if (option == 5) CHECK(about(took, 500, 10));
                if (option == 6) CHECK(about(took, 10, 3));
                if (option == 7) CHECK((release != 0 ? took > 1000 : took < 3)); // rolls out without power
                CHECK(b.status().left.shaft == shaft_state::emergency_stop);
                b.order(command::enable);
                CHECK(!b.drive.enabled());
                b.drive.set_input(inverted, inverted);
                b.run(1000);
                CHECK(b.drive.stands_still());
                b.order(command::enable);
                CHECK(b.drive.enabled());
            }
        }
    }
}

TEST_CASE("outputs show alarm and state, with their polarity") {
    bench b;
    b.set(map::y0_function, 1);
    b.set(map::y1_function, 2);
    CHECK(b.get(map::output_state).to_word() == 0);
    b.begin(operating_mode::velocity);
    CHECK(b.get(map::output_state).to_word() == 2);
    b.drive.raise(fault::overload, fault::none);
    CHECK(b.get(map::output_state).to_word() == 1);
    b.set(map::output_polarities, 3);
    CHECK(b.get(map::output_state).to_word() == 2);
}

TEST_CASE("a closed brake blocks its wheel; driven against it the wheel is overloaded in time") {
    bench b;
    b.set(map::left_brake, 1);
    b.set(map::left_overload_time, 100);
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {50, 50}) == 0);
    b.run(900);
    CHECK(b.drive.left().position == 0);
    CHECK(b.drive.right().speed == 50 * one_r_per_min);
    b.run(101);
    CHECK(b.get(map::left_faults).has(fault::overload));
    b.run_until_still();
    CHECK(!b.drive.enabled());
}

TEST_CASE("the Hall state runs through its six values as the wheel turns") {
    bench b;
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {2, -2}) == 0);
    unsigned seen = 0;
    unsigned changes = 0;
    unsigned last = b.get(map::hall_state).left;
    for (int i = 0; i < 30'000; ++i) {
        b.run(1);
        const map::hall_inputs h = b.get(map::hall_state);
        CHECK((h.left >= 1 && h.left <= 6 && h.right >= 1 && h.right <= 6));
        seen |= 1u << h.left;
        if (h.left != last) ++changes;
        last = h.left;
    }
    CHECK(seen == 0x7E);
    CHECK(about(changes, 90, 2)); // one turn, 15 pairs of poles
}

// Memory

TEST_CASE("G17: only a save keeps values over a power cycle, and it counts its writes to the EEPROM") {
    std::uint32_t saved_rows = 0;
    for (const entry& e : map::catalogue.entries) saved_rows += has(e.flags, saved) ? 1u : 0u;
    bench b;
    b.set(map::max_motor_speed, 300);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 1000);
    CHECK(b.drive.eeprom_writes() == 0);
    b.set(map::max_motor_speed, 300);
    b.set(map::left_acceleration_time, 100); // RW without S
    b.set(map::save_parameters, 1);
    CHECK(b.get(map::save_parameters) == map::parameter_save::none);
    CHECK(b.drive.saves() == 1);
    CHECK(b.drive.eeprom_writes() == saved_rows);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 300);
    CHECK(b.get(map::left_acceleration_time) == 500);
}

TEST_CASE(
    "G21: after a power cycle mode, control word, targets and feedback are zero and the drive is disabled") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.drive.power_cycle();
    CHECK(b.get(map::mode_of_operation) == operating_mode::undefined);
    CHECK(b.get(map::control_word) == command::undefined);
    CHECK(b.get(map::left_target_speed) == 0);
    CHECK(b.get(map::left_actual_position) == 0);
    CHECK(!b.drive.enabled());
    CHECK(!b.drive.stands_still()); // it rolls on
    CHECK(b.run_until_still() > 500);
}

TEST_CASE("with 2007h = 1 the shaft is locked at power-on without being enabled") {
    bench b;
    b.set(map::shaft_at_power_on, 1);
    b.set(map::save_parameters, 1);
    CHECK(b.status().left.shaft == shaft_state::released);
    b.drive.power_cycle();
    CHECK(b.status().left.shaft == shaft_state::locked);
    CHECK(!b.drive.enabled());
    b.order(command::stop);
    CHECK(b.status().left.shaft == shaft_state::released);
}

TEST_CASE("factory reset restores everything, while disabled only") {
    bench b;
    b.set(map::max_motor_speed, 300);
    b.set(map::left_target_torque, 77);
    b.set(map::save_parameters, 1);
    b.begin(operating_mode::relative_position);
    b.set(map::restore_parameters, 1);
    CHECK(b.get(map::max_motor_speed) == 300);
    b.order(command::stop);
    b.run(10);
    b.set(map::restore_parameters, 1);
    CHECK(b.get(map::max_motor_speed) == 1000);
    CHECK(b.get(map::left_target_torque) == 0);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 1000);
}

TEST_CASE("one run is the same however often the clock is looked at") {
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

// Faults of the line

namespace {
constexpr sim::fault_plan parsed(const char* text) {
    sim::fault_plan plan;
    return sim::parse_faults(text, plan) ? plan : sim::fault_plan{.lost_response = 999};
}
static_assert(parsed("late").late_response != 0 && parsed("late").lost_response == 0);
static_assert(parsed("late,lossy").late_response != 0 && parsed("late,lossy").lost_request != 0);
static_assert(parsed("noisy,doubled").noise_after != 0 && parsed("noisy,doubled").doubled_response != 0);
static_assert(parsed("none").lost_response == 0 && parsed("unplugged").is_unplugged &&
              parsed("cut").cut_response != 0);
static_assert(parsed("").lost_response == 999 && parsed("late,").lost_response == 999 &&
              parsed("lat").lost_response == 999);
static_assert(parsed("later").lost_response == 999 && parsed(",late").lost_response == 999);
} // namespace

TEST_CASE("an unknown fault leaves the plan as it was") {
    sim::fault_plan plan;
    CHECK(!sim::parse_faults("doubled,tripled", plan));
    CHECK(plan.doubled_response == 0);
}

TEST_CASE("a fault source strikes as often as planned, and one seed decides the same") {
    sim::fault_plan plan{.lost_response = 100, .late_response = 500, .doubled_response = 1000};
    sim::fault_source a{42, plan};
    sim::fault_source b{42, plan};
    int lost = 0;
    int late = 0;
    for (int i = 0; i < 10'000; ++i) {
        const sim::fate f = a.decide();
        const sim::fate g = b.decide();
        CHECK((f.is_lost == g.is_lost && f.delay == g.delay && f.seed == g.seed));
        CHECK((f.is_doubled && !f.is_cut && f.noise_before == 0));
        lost += f.is_lost ? 1 : 0;
        late += f.delay == plan.late_by ? 1 : 0;
    }
    CHECK(about(lost, 1000, 150));
    CHECK(about(late, 5000, 250));
}

TEST_CASE("a fault spoils a frame as it says") {
    const std::vector<std::uint8_t> frame{1, 2, 3, 4, 5, 6, 7, 8};
    std::array<std::uint8_t, sim::max_spoiled> out{};
    const auto size = [&](const sim::fate& f) { return sim::spoil(f, frame, out); };
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        CHECK(size({.seed = seed}) == 8);
        CHECK(same_bytes(bytes{out}.first(8), frame));
        CHECK(size({.is_lost = true, .seed = seed}) == 0);
        CHECK(size({.is_cut = true, .seed = seed}) < 8);
        CHECK(size({.noise_before = 2, .noise_after = 3, .seed = seed}) == 13);
        CHECK(same_bytes(bytes{out}.subspan(2, 8), frame));
        CHECK(size({.is_corrupted = true, .seed = seed}) == 8);
        int wrong = 0;
        for (std::size_t i = 0; i < 8; ++i) wrong += out[i] != frame[i] ? 1 : 0;
        CHECK(wrong == 1);
    }
}

// The line

namespace {

static_assert(waiting_port<sim::virtual_line>);
static_assert(port<sim::virtual_line>);

using wire_line = line<sim::virtual_line>;

struct machine {
    sim::zlac8015d drive{};
    sim::station<sim::zlac8015d> station{drive};
    sim::virtual_line wire;
    wire_line on;
    client<wire_line, map::device> wheels;

    explicit machine(const sim::line_settings& settings = {})
        : wire{settings}, on{wire, modbus::timing_at(settings.baud)}, wheels{on, node<map::device>{1}} {
        wire.attach(station);
    }
};

} // namespace

TEST_CASE("the virtual line carries requests and responses, with real wire times") {
    machine m;
    CHECK(m.wheels.read<map::bus_voltage>().value().count() == 2400);
    const std::uint64_t before = m.wire.time_us();
    for (int i = 0; i < 100; ++i) CHECK(m.wheels.read<map::bus_voltage>());
    const std::uint64_t each = (m.wire.time_us() - before) / 100;
    // 8 + 7 characters of 96 us, t3.5 before the request and before the response
    CHECK(each >= 15 * 96 + 2 * 1750);
    CHECK(each <= (15 * 96 + 2 * 1750) * 101 / 100);
    CHECK(m.wire.requests() == 101);
    CHECK(m.wire.responses() == 101);
    CHECK(m.wire.collisions() == 0);
    CHECK(m.station.server().dropped() == 0);
}

TEST_CASE("the virtual line's clock goes on through its wrap, and drives with it") {
    machine m{{.start = instant{0xFFFF'FFFFu - 300'000}}};
    CHECK(m.wheels.write<map::mode_of_operation>(operating_mode::velocity));
    CHECK(m.wheels.write<map::control_word>(command::enable));
    CHECK(m.wheels.write<map::left_target_speed>(raw(60)));
    for (int i = 0; i < 100; ++i) {
        CHECK(m.wheels.read<map::left_actual_speed>());
        m.wire.pass(milliseconds(20));
    }
    CHECK(m.wheels.read<map::left_actual_speed>().value().count() == 600);
}

TEST_CASE("a device's response delay is kept") {
    machine m;
    (void)m.wheels.read<map::bus_voltage>();
    m.station.set_response_delay(milliseconds(50));
    const std::uint64_t before = m.wire.time_us();
    CHECK(m.wheels.read<map::bus_voltage>());
    CHECK(about(static_cast<std::int64_t>(m.wire.time_us() - before), 1750 + 15 * 96 + 50'000, 100));
    m.station.set_response_delay(milliseconds(150));
    m.wheels.node().read_retries = 0;
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
}

TEST_CASE("several drives answer at their own addresses, and 20 hours pass quickly") {
    std::array<sim::zlac8015d, 3> drives{};
    std::array<sim::station<sim::zlac8015d>, 3> stations{sim::station{drives[0], 1, 115200},
                                                         sim::station{drives[1], 1, 115200},
                                                         sim::station{drives[2], 1, 115200}};
    sim::virtual_line wire{115200};
    wire_line on{wire, modbus::timing_at(115200)};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto unit = static_cast<std::uint8_t>(10 + i);
        const std::array<std::uint8_t, 2> raw{0, unit};
        const std::array<std::uint8_t, 2> one{0, 1};
        CHECK(drives[i].write(0x2001, words_view{raw}) == 0);
        CHECK(drives[i].unit() == 1); // not before the next power-on
        CHECK(drives[i].write(0x2010, words_view{one}) == 0);
        drives[i].power_cycle();
        CHECK(drives[i].unit() == unit);
        drives[i].set_bus_voltage(static_cast<std::uint16_t>(1000 + i));
        CHECK(wire.attach(stations[i]));
    }
    for (int round = 0; round < 40; ++round) {
        for (std::size_t i = 0; i < 3; ++i) {
            client<wire_line, map::device> c{on, node<map::device>{static_cast<std::uint8_t>(10 + i)}};
            CHECK(c.read<map::bus_voltage>().value().count() == static_cast<int>(1000 + i));
        }
        wire.pass(milliseconds(1'800'000));
    }
    CHECK(wire.time_us() > std::uint64_t{20} * 3'600'000'000);
}

TEST_CASE("a drive at another baud rate is not understood, and is when the line is set to its rate") {
    machine m;
    CHECK(m.wheels.write<map::rs485_baud_rate>(map::baud_rate::baud_9600));
    CHECK(m.wheels.read<map::bus_voltage>()); // still the old rate
    CHECK(m.wheels.write<map::save_parameters>(map::parameter_save::save_all));
    m.drive.power_cycle();
    CHECK(m.drive.baud() == 9600);
    CHECK(!m.wheels.read<map::bus_voltage>());
    m.wire.set_baud(9600);
    wire_line slow{m.wire, modbus::timing_at(9600)};
    client<wire_line, map::device> c{slow, node<map::device>{1}};
    CHECK(c.read<map::bus_voltage>());
}

TEST_CASE("an unplugged port says so, a cut wire and an absent device are silent, and all come back") {
    machine m;
    m.wheels.node().read_retries = 0;
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.unplug();
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::port_lost);
    m.wire.plug();
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.cut_for(milliseconds(50));
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.set_connected(0, false);
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
    m.drive.power_cycle();
    m.wire.set_connected(0, true);
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.faults().is_unplugged = true;
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
}

TEST_CASE("two devices at one address spoil each other's responses") {
    machine m;
    sim::zlac8015d twin;
    sim::station other{twin};
    m.wire.attach(other);
    m.wheels.node().read_retries = 0;
    CHECK(!m.wheels.read<map::bus_voltage>());
    CHECK(m.wire.collisions() > 0);
    other.set_response_delay(milliseconds(2)); // the second begins in the middle of the first
    const std::uint32_t before = m.wire.collisions();
    CHECK(!m.wheels.read<map::status_word>());
    CHECK(m.wire.collisions() > before);
}

TEST_CASE("each planned fault has its effect at the client, and never a wrong value") {
    for (const char* names : {"late", "lossy", "noisy", "doubled", "cut", "late,lossy,noisy,doubled,cut"}) {
        CAPTURE(std::string{names});
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            machine m{{.seed = seed}};
            m.wheels.node().read_retries = 0;
            sim::fault_plan plan;
            CHECK(sim::parse_faults(names, plan));
            m.wire.faults() = plan;
            int failed = 0;
            for (std::uint16_t i = 0; i < 1000; ++i) {
                m.drive.set_bus_voltage(static_cast<std::uint16_t>(2000 + i));
                const auto got = m.wheels.read<map::bus_voltage>();
                if (!got) {
                    ++failed;
                    continue;
                }
                CHECK(got->count() == 2000 + i);
            }
            CHECK(failed < 400);
            CHECK(m.wire.struck() > 10);
        }
    }
}

TEST_CASE("one seed replays one run, byte for byte") {
    const auto run = [](std::uint64_t seed) {
        std::vector<std::uint64_t> log;
        machine m{{.seed = seed}};
        m.wire.set_hook(
            [](void* context, const sim::wire_byte& b) {
                static_cast<std::vector<std::uint64_t>*>(context)->push_back(
                    b.at_us << 9 | std::uint64_t{b.value} << 1 | (b.is_from_client ? 1u : 0u));
            },
            &log);
        sim::parse_faults("late,lossy,noisy,doubled,cut", m.wire.faults());
        for (int i = 0; i < 200; ++i) (void)m.wheels.read<map::left_actual_position>();
        return log;
    };
    const auto first = run(7);
    CHECK(first.size() > 2000);
    CHECK(run(7) == first);
    CHECK(run(8) != first);
}

TEST_CASE("an echo is heard by the client while it sends, a delayed one behind it") {
    for (const std::uint32_t delay : {0u, 250u}) {
        machine m{{.echoes = true, .echo_delay = microseconds(delay)}};
        const std::array<std::uint8_t, 5> out{1, 2, 3, 4, 5};
        CHECK(*m.wire.send(out) == 5);
        m.wire.pass(microseconds(96 * 4));
        std::array<std::uint8_t, 8> in{};
        CHECK(*m.wire.receive(in) == (delay == 0 ? 4 : 1));
        while (!m.wire.sent()) {}
        CHECK(*m.wire.receive(in) == 0); // the port has emptied itself
        m.wire.pass(milliseconds(1));
        CHECK(*m.wire.receive(in) == (delay == 0 ? 0 : 3));
        if (delay == 0) CHECK(m.wheels.read<map::bus_voltage>());
    }
}

TEST_CASE("G14: the simulated drive answers over the line with the exceptions of its manual") {
    machine m;
    std::array<u16, 2> words{};
    CHECK(m.wheels.read_words(0x2015, std::span<u16>{words}.first(1)) == failure{errc::exception, 2});
    CHECK(m.wheels.write_word(0x2008, 0).why() == failure{errc::exception, 3});
    CHECK(m.wheels.write_word(0x20A1, 0).why() == failure{errc::exception, 2});
    CHECK(m.wheels.read_words(0x2000, words, modbus::function::read_input_registers) ==
          failure{errc::exception, 1});
}

TEST_CASE("broadcast writes reach every drive on the line") {
    machine m;
    sim::zlac8015d second;
    sim::station at_the_second{second, 2, 115200};
    const std::array<std::uint8_t, 2> two{0, 2};
    const std::array<std::uint8_t, 2> one{0, 1};
    CHECK(second.write(0x2001, words_view{two}) == 0);
    CHECK(second.write(0x2010, words_view{one}) == 0);
    second.power_cycle();
    m.wire.attach(at_the_second);
    CHECK(m.wheels.broadcast<map::left_acceleration_time>(123));
    CHECK(m.drive.peek(0x2080) == 123);
    CHECK(second.peek(0x2080) == 123);
    CHECK(m.wire.responses() == 0);
}
