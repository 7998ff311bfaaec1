// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated YAKOTEC steppers between two states: starts that are cancelled before they begin, stops and
// alarms in sequence, limits during a homing, clocks that go back.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

namespace sim_yako_states_tests {

using namespace servobus;
using namespace yako_bench;

TEST_CASE("if the clock goes back, the drive takes over the new time and does not move in between") {
    closed b;
    b.command(motion_code::jog());
    b.run(200);
    const std::int64_t at = b.drive.view().position;
    b.now = instant{b.now.us - 5'000'000};
    b.drive.advance(b.now);
    CHECK(b.drive.view().position == at);
    b.run(10);
    CHECK(about(b.drive.view().position, at + 20, 2)); // 120 r/min of 1000 pulses
}

TEST_CASE_TEMPLATE("peek gives 0 for an address that does not exist", B, closed, open) {
    B b;
    CHECK(b.drive.peek(0xFFFF) == 0);
    CHECK(b.drive.peek(0x0004) == 0); // a gap
    CHECK(b.drive.peek(cl::jog_speed.address) == 120);
}

TEST_CASE("a move that is interrupted by one to its present position returns to it") {
    closed b;
    b.set(cl::start_speed, 480);
    b.set(cl::positioning_speed, 480); // two pulses each tick, and one in the first
    b.set(servobus::yako::acceleration_time, 0);
    b.set(servobus::yako::deceleration_time, 100);
    b.move(1000);
    b.run(100);
    const std::int64_t there = b.drive.view().commanded;
    REQUIRE(there > 50);
    b.move(there, positioning::absolute, while_moving::interrupt);
    b.run(1);
    CHECK(b.status().is_moving()); // it does not stop within a tick
    b.run_until_still();
    CHECK(b.position() == there);
}

// Delayed starts

TEST_CASE("a stop in the start delay, or in the tick of the start, leaves no motion") {
    for (const std::uint32_t delay : {0u, 20u}) {
        CAPTURE(delay);
        closed b{{.start_delay = milliseconds(delay)}};
        b.run(10);
        b.move(1000);
        b.command(motion_code::stop());
        b.run(100);
        CHECK(b.position() == 0);
        CHECK_FALSE(b.status().is_moving());
        CHECK(b.drive.starts() == 1);
        b.move(1000);
        b.run(100);
        b.run_until_still();
        CHECK(b.position() == 1000);
    }
}

TEST_CASE("an input that ends before its motion begins moves nothing, and an emergency stop cancels the "
          "start") {
    for (const bool is_emergency : {false, true}) {
        CAPTURE(is_emergency);
        closed b{{.start_delay = milliseconds(50)}};
        assign(b, 0, input_function::jog_positive);
        assign(b, 3, input_function::emergency_stop);
        b.set(cl::jog_speed, 3000);
        b.set(servobus::yako::jog_acceleration_time, 0); // so that even a tick of motion would show
        b.run(10);
        press(b, 0); // 20 ms
        REQUIRE(b.drive.starts() == 1);
        is_emergency ? press(b, 3) : let_go(b, 0);
        b.run(100);
        CHECK(b.position() == 0);
        CHECK_FALSE(b.status().is_moving());
    }
}

TEST_CASE("with 0051h = 1 a PT trigger at standstill starts a move too, and one during positioning is "
          "ignored") {
    closed b;
    assign(b, 1, input_function::pt_trigger);
    b.set(cl::pv_trigger_mode, 1);
    b.set(cl::position_segment_targets[0], 2000);
    b.set(cl::position_segment_speeds[0], 60);
    b.run(20);
    press(b, 1);
    CHECK(b.drive.starts() == 1);
    let_go(b, 1);
    press(b, 1);
    CHECK(b.drive.starts() == 1);
    b.run_until_still();
    CHECK(b.position() == 2000);
}

TEST_CASE("inputs of a drive at standstill are not lost, however long they have been held") {
    closed b;
    assign(b, 0, input_function::pt_trigger);
    assign(b, 3, input_function::pin0);
    b.set(cl::position_segment_targets[1], 300);
    b.run(3000);
    b.drive.set_input(3, true);
    b.run_us(700'000);
    b.run_us(2'000'000);
    press(b, 0);
    b.run_until_still();
    CHECK(b.position() == 300); // segment 1
}

TEST_CASE("a switch that a pushed shaft passes on its way back starts a segment without a command") {
    closed b;
    auto m = sim::yako_machine::none();
    m.home_input = 0;
    m.home_from = -10'000;
    m.home_to = 60; // a millisecond before it stops again
    b.drive.attach(m);
    assign(b, 0, input_function::pt_trigger);
    b.set(cl::following_error_limit, 65'535);
    b.set(cl::position_segment_targets[0], -300);
    b.run(2000);
    b.drive.push_shaft(60'000); // it returns at 3000 r/min: 50 pulses per millisecond
    b.run(700);
    REQUIRE(b.drive.view().shaft > 10'000);
    CHECK(b.drive.starts() == 0);
    b.run_us(3'000'000);
    CHECK(b.drive.starts() == 1);
    CHECK(b.position() == -300);
}

// Without power

TEST_CASE("an emergency stop of a released motor has no effect: the motor coasts") {
    closed b;
    b.set(cl::jog_speed, 600);
    b.command(motion_code::jog());
    b.run(500);
    b.command(auxiliary::release);
    b.run(5);
    const auto before = b.speed();
    REQUIRE(before > 300);
    b.command(motion_code::emergency_stop());
    b.run(5);
    CHECK(b.speed() > before * 9 / 10);
    CHECK(b.speed() < before);
}

TEST_CASE("the first alarm stays until it is cleared, whatever follows it") {
    closed b;
    b.drive.raise_alarm(2);
    b.drive.raise_alarm(5);
    CHECK(b.drive.alarm() == 2);
    CHECK(b.get(cl::error_code) == 2);
    b.drive.end_alarm();
    b.command(auxiliary::clear_alarm);
    CHECK(b.drive.alarm() == 0);
}

// Limits during homing

TEST_CASE("a limit input for which a homing searches does not stop it, not even in the tick in which it "
          "becomes active") {
    for (const bool is_positive : {false, true}) {
        CAPTURE(is_positive);
        open b;
        assign(b, 0, is_positive ? input_function::positive_limit : input_function::negative_limit);
        b.set(cl::homing_method, is_positive ? 18 : 17);
        b.command(motion_code::home());
        b.run(500);
        const int way = is_positive ? 1 : -1;
        REQUIRE(b.speed() * way > 0);
        b.drive.set_input(0, true);
        b.run(500);
        CHECK(b.drive.enabled());
        CHECK(b.speed() * way < 0); // back, slowly
        b.drive.set_input(0, false);
        b.run(20);
        CHECK(b.status().is_homed());
        CHECK(b.drive.view().home_direction == -way);
    }
}

TEST_CASE("a homing that leaves its switch and meets the limit ends there: only a search reverses") {
    open b;
    assign(b, 0, input_function::home);
    assign(b, 1, input_function::negative_limit);
    b.drive.set_input(0, true); // as if it were stuck
    b.run(10);
    b.set(cl::homing_method, 24);
    b.command(motion_code::home());
    b.run(500);
    REQUIRE(b.speed() < 0);
    b.drive.set_input(1, true);
    b.run(3000);
    CHECK_FALSE(b.status().is_homed());
    CHECK_FALSE(b.status().is_moving());
    CHECK_FALSE(b.drive.enabled()); // 0017h: it coasts
}

} // namespace sim_yako_states_tests
