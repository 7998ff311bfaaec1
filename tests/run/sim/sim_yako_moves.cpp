// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The moves of the simulated YAKOTEC steppers: relative and absolute ones, jog, stops, the scales of a
// position, releasing the motor; alarms, a blocked or pushed shaft; and the exact end of each move.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <type_traits>

#include <servobus/sim/yako.hpp>

#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

namespace sim_yako_moves_tests {

using namespace servobus;
using namespace yako_bench;

// Moves

TEST_CASE_TEMPLATE("a relative move ends exactly at its target, in the time of its trapezoid", B, BOTH) {
    B b;
    b.run(20);
    b.set(cl::start_speed, 0);
    b.set(cl::positioning_speed, 600); // 10000 pulses/s
    b.set(cl::acceleration_time, 200);
    b.set(cl::deceleration_time, 300);
    b.move(10'000);
    CHECK(about(b.run_until_still(), 2 + 1000 + 250, 15));
    CHECK(b.position() == 10'000);
    CHECK(b.drive.view().shaft == 10'000);
    CHECK(b.status().is_in_position());
    b.move(-3'000);
    b.run(220);
    CHECK(b.speed() == -600);
    b.run_until_still();
    CHECK(b.position() == 7'000);
    b.move(-100, positioning::absolute);
    b.run_until_still();
    CHECK(b.position() == -100);
    CHECK(b.drive.starts() == 3);
}

TEST_CASE("a move begins and ends with the start speed") {
    closed b;
    b.set(cl::start_speed, 60);
    b.set(cl::positioning_speed, 300);
    b.set(cl::acceleration_time, 1000);
    b.move(20'000);
    b.run_us(2250);
    CHECK(about(b.drive.view().speed, 60 * one_r_per_min, one_r_per_min));
    b.run(400);
    CHECK(about(b.speed(), 180, 3));
}

TEST_CASE_TEMPLATE("status and motion follow the acknowledged start after a delay", B, BOTH) {
    B b{{.start_delay = milliseconds(5)}};
    b.run(20);
    CHECK(b.status().to_word() == motion_status::in_position_bit);
    b.move(1000);
    b.run_us(4500);
    CHECK(b.status().to_word() == motion_status::in_position_bit);
    CHECK(b.position() == 0);
    b.command(motion_code::jog()); // ignored: a start is in progress
    b.run_us(750);
    CHECK(b.status().to_word() == motion_status::moving_bit);
    b.run_until_still();
    CHECK(b.position() == 1000);
    CHECK(b.drive.starts() == 1);
    b.move(1000);
    b.command(motion_code::stop()); // before it began
    b.run(100);
    CHECK(b.position() == 1000);
}

TEST_CASE("in position follows the standstill after the time 010Ch, also after a stop") {
    closed b;
    b.set(cl::in_position_time, 50);
    b.command(motion_code::jog());
    b.run(200);
    b.command(motion_code::emergency_stop());
    b.run(1);
    CHECK(b.status().to_word() == 0);
    b.run(45);
    CHECK(!b.status().is_in_position());
    b.run(5);
    CHECK(b.status().is_in_position());
}

TEST_CASE("during a move a new one is ignored without bit 3 and executed immediately with it") {
    closed b;
    b.move(10'000);
    b.run(100);
    b.move(5, positioning::absolute);
    CHECK(b.drive.starts() == 1);
    b.run(100);
    b.move(-500, positioning::absolute, while_moving::interrupt);
    CHECK(b.drive.starts() == 2);
    b.run_until_still();
    CHECK(b.position() == -500);
    b.command(motion_code::jog());
    b.run(300);
    const std::int64_t at = b.drive.view().commanded;
    b.move(2000, positioning::relative, while_moving::interrupt); // from where it is
    b.run_until_still();
    CHECK(b.drive.view().commanded == at + 2000);
}

TEST_CASE_TEMPLATE("a jog runs in the direction of the sign of 001Dh until a stop", B, BOTH) {
    B b;
    b.set(cl::jog_speed, -300);
    b.set(cl::jog_acceleration_time, 400);
    b.command(motion_code::jog());
    b.run(202);
    CHECK(about(b.speed(), -150, 2));
    b.run(300);
    CHECK(b.speed() == -300);
    b.set(cl::jog_speed, 100); // for the next one
    b.command(motion_code::jog());
    b.command(motion_code::home());
    b.run(50);
    CHECK(b.speed() == -300);
    CHECK(b.drive.starts() == 1);
    CHECK(b.status().is_moving());
}

TEST_CASE("a stop uses the deceleration time that was set before the start") {
    closed b;
    b.set(cl::jog_deceleration_time, 1000);
    b.command(motion_code::jog());
    b.run(300);
    b.set(cl::jog_deceleration_time, 0);
    b.command(motion_code::stop());
    b.run(500);
    CHECK(about(b.speed(), 60, 2));
    b.run(510);
    CHECK(!b.status().is_moving());

    b.set(cl::deceleration_time, 0);
    b.move(100'000);
    b.run(300);
    b.set(cl::deceleration_time, 2000);
    b.command(motion_code::stop());
    b.run(1);
    CHECK(!b.status().is_moving());
}

TEST_CASE("an emergency stop ends in standstill within a tick, and overrides a start in the same word") {
    closed b;
    b.set(cl::jog_speed, 3000);
    b.command(motion_code::jog());
    b.run(300);
    b.command(motion_code::emergency_stop());
    const std::int64_t at = b.drive.view().shaft;
    b.run(100);
    CHECK(b.drive.view().shaft == at);
    CHECK(b.status().is_enabled());
    b.set(cl::motion_command, 0x0201);
    b.run(10);
    CHECK(!b.status().is_moving());
    CHECK(b.drive.starts() == 1);
    CHECK(b.get(cl::motion_command).to_word() == 0);
}

TEST_CASE("0010h reverses the direction of the motor and keeps the value of the position") {
    closed b;
    b.move(300);
    b.run_until_still();
    b.set(cl::motion_direction, 1);
    CHECK(b.position() == 300);
    b.move(100);
    b.run_until_still();
    CHECK(b.position() == 400);
    CHECK(b.drive.view().shaft == 200);
    b.move(0, positioning::absolute);
    b.run(20);
    b.set(cl::motion_direction, 0); // at the next standstill
    b.run(20);
    CHECK(b.position() < 400);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 600);
    CHECK(b.position() == 0);
    b.move(100);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 700);
}

TEST_CASE("0011h sets the pulses per turn") {
    closed b;
    b.set(cl::microstep_resolution, 4000);
    b.set(cl::jog_speed, 60);
    b.set(cl::jog_acceleration_time, 0);
    b.command(motion_code::jog());
    b.run(1002);
    CHECK(about(b.position(), 4000, 20));
    b.command(motion_code::emergency_stop());
    const std::int32_t at = b.position();
    b.run(1);
    b.set(cl::microstep_resolution, 1000);
    CHECK(b.position() == at);
    CHECK(about(b.drive.view().shaft, at / 4, 1));
}

TEST_CASE("0011h scales lost steps and the positions of a machine") {
    open b;
    b.drive.push_shaft(100);
    b.set(cl::microstep_resolution, 4000);
    CHECK(b.drive.view().shaft == 400);
    CHECK(b.drive.view().commanded == 0);
    sim::yako_machine m = simulated::yako_slide();
    m.home_from = -4; // 1.6 of 400 pulses before 0
    b.drive.attach(m);
    b.set(cl::microstep_resolution, 400);
    b.set(cl::homing_slow_speed, 5);
    b.command(motion_code::home());
    b.run(5);
    b.run_until_still();
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == -2);
}

TEST_CASE("001Ah rescales written and read speeds on closed loop") {
    closed b;
    b.set(cl::jog_speed, 600);
    b.set(cl::speed_resolution, 1);
    b.command(motion_code::jog());
    b.run(300);
    CHECK(b.drive.view().speed == 60 * one_r_per_min);
    CHECK(b.speed() == 600);
    b.set(cl::speed_resolution, 0);
    CHECK(b.speed() == 60);
    CHECK(open{}.write(0x001A, 0) == 3);
}

// 002Dh

TEST_CASE_TEMPLATE("after a release the motor coasts, bit 4 shows it as released, and starts are ignored "
                   "until an enable",
                   B, BOTH) {
    B b;
    b.command(motion_code::jog());
    b.run(300);
    const std::int32_t released_at = b.position();
    b.command(auxiliary::release);
    b.run(20);
    CHECK(!b.status().is_enabled());
    // An encoder follows the coasting shaft. An open loop drive does not detect it.
    CHECK((b.speed() != 0) == std::is_same_v<B, closed>);
    CHECK((b.position() != released_at) == std::is_same_v<B, closed>);
    CHECK(b.status().is_moving() == std::is_same_v<B, closed>);
    CHECK((b.status().to_word() & motion_status::released_bit) != 0);
    const std::int64_t at = b.drive.view().shaft;
    b.run(50);
    CHECK(b.drive.view().shaft > at);
    b.command(motion_code::jog());
    b.move(100);
    b.command(motion_code::home());
    b.run(5000);
    CHECK(!b.status().is_moving());
    CHECK(b.drive.starts() == 1);
    b.command(auxiliary::enable);
    CHECK(b.status().is_enabled());
    const std::int32_t counted = b.position();
    b.run(20);
    CHECK(b.position() == counted);
    b.move(100);
    b.run_until_still();
    CHECK(b.position() == counted + 100);
}

TEST_CASE("clear position sets zero; absolute moves refer to it, homed or not") {
    closed b;
    b.move(700);
    b.run_until_still();
    b.command(auxiliary::clear_position);
    CHECK(b.position() == 0);
    CHECK(!b.status().is_homed());
    b.move(50, positioning::absolute);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 750);
}

// Alarms and the shaft

TEST_CASE_TEMPLATE("an alarm stops and releases the motor; it can be cleared once its cause is "
                   "gone",
                   B, BOTH) {
    for (std::uint16_t code = 1; code <= 5; ++code) {
        B b;
        b.command(motion_code::jog());
        b.run(100);
        b.drive.raise_alarm(code);
        CHECK(b.get(cl::error_code) == code);
        CHECK(b.status().has_alarm());
        CHECK(!b.status().is_enabled());
        b.command(auxiliary::enable);
        b.command(auxiliary::clear_alarm);
        CHECK(b.status().has_alarm());
        b.drive.end_alarm();
        CHECK(b.status().has_alarm());
        b.command(auxiliary::clear_alarm);
        CHECK(!b.status().has_alarm());
        CHECK(b.get(cl::error_code) == 0);
        CHECK(!b.status().is_enabled());
        b.command(auxiliary::enable);
        CHECK(b.status().is_enabled());
    }
}

TEST_CASE("an alarm whose cause persists is present again after a power cycle") {
    closed b;
    b.drive.raise_alarm(2);
    b.drive.power_cycle();
    CHECK(b.drive.alarm() == 2);
    CHECK(!b.drive.enabled());
    b.drive.end_alarm();
    b.drive.power_cycle();
    CHECK(b.drive.alarm() == 0);
    CHECK(b.drive.enabled());
}

TEST_CASE("closed loop: a blocked shaft causes a following error and alarm 4") {
    closed b;
    b.set(cl::following_error_limit, 500);
    b.drive.block_shaft(true);
    b.move(400);
    b.run(100);
    CHECK(b.status().is_moving());
    CHECK(b.speed() == 0);
    b.run(2000);
    CHECK(b.position() == 0);
    CHECK(!b.status().is_moving());
    CHECK(!b.status().is_in_position());
    CHECK(!b.status().has_alarm());
    b.move(400);
    b.run(2000);
    CHECK(b.get(cl::error_code) == 4);
    b.drive.block_shaft(false);
    b.command(auxiliary::clear_alarm);
    b.command(auxiliary::enable);
    b.run(100);
    CHECK(b.status().is_in_position());
    CHECK(b.position() == 0);
}

TEST_CASE("closed loop moves a pushed shaft back, open loop does not detect the push") {
    closed c;
    c.run(3000); // at rest
    c.drive.push_shaft(30);
    CHECK(c.position() == 30);
    CHECK(!c.status().is_in_position());
    c.run(100);
    CHECK(c.position() == 0);
    c.set(cl::following_error_limit, 65535);
    c.drive.push_shaft(50'000);
    c.run(3000);
    CHECK(c.position() == 0);
    c.set(cl::following_error_limit, 4000);
    c.drive.push_shaft(4500);
    c.run(1);
    CHECK(c.get(cl::error_code) == 4);

    open o;
    o.drive.push_shaft(30);
    o.run(100);
    CHECK(o.position() == 0);
    o.drive.block_shaft(true);
    o.move(500);
    o.run_until_still();
    CHECK(o.position() == 500);
    CHECK(o.drive.view().shaft == 30);
    CHECK(o.status().is_in_position());
}

// Time

TEST_CASE("the result does not depend on how often the clock advances") {
    closed fine;
    closed coarse;
    for (closed* b : {&fine, &coarse}) {
        b->run(3000);
        b->move(20'000);
    }
    for (int i = 0; i < 4000; ++i) fine.run_us(250);
    coarse.run_us(1'000'000);
    CHECK(fine.drive.view().position == coarse.drive.view().position);
    CHECK(fine.drive.view().speed == coarse.drive.view().speed);
    CHECK(fine.status() == coarse.status());
}

TEST_CASE("long moves at every resolution end exactly") {
    for (const int pulses : {400, 1000, 51200}) {
        for (const int speed : {1, 60, 3000}) {
            for (const int time : {0, 1, 2000}) {
                CAPTURE(pulses);
                CAPTURE(speed);
                CAPTURE(time);
                open b;
                b.set(cl::microstep_resolution, pulses);
                b.set(cl::positioning_speed, speed);
                b.set(cl::acceleration_time, time);
                b.set(cl::deceleration_time, time);
                const std::int64_t target = std::int64_t{pulses} * speed / 15 + 7; // four seconds
                b.move(-target);
                const std::uint32_t took = b.run_until_still();
                CHECK(took < 4000 + 2000 + 1000);
                CHECK(b.position() == -target);
            }
        }
    }
}

} // namespace sim_yako_moves_tests
