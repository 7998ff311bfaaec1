// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rare cases of the simulated ZLAC8015D: brakes that close while a wheel stops, inputs and outputs with other
// functions, parking, encoders without lines, clocks that go back.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_states_tests {

using namespace servobus;
using namespace zlac8015d_bench;

namespace {

void run_at(bench& b, int r_per_min) {
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {r_per_min, r_per_min}) == 0);
    b.run(1500);
    REQUIRE(b.drive.left().speed == r_per_min * one_r_per_min);
}

} // namespace

TEST_CASE("if the clock goes back, the drive takes over the new time, does not move in between, and no "
          "watchdog expires") {
    bench b;
    run_at(b, 60);
    const std::int64_t at = b.drive.left().position;
    b.now = instant{b.now.us - 50'000'000};
    b.drive.advance(b.now);
    CHECK(b.drive.left().position == at);
    b.run(100);
    CHECK(about(b.drive.left().position, at + 410, 5)); // 4096 counts a second
    CHECK_FALSE(b.drive.in_watchdog_stop());
}

TEST_CASE("20B0h shows the temperature that a test sets, and peek gives 0 for missing addresses") {
    bench b;
    CHECK(b.get(map::driver_temperature) == 350);
    b.drive.set_driver_temperature(-55);
    CHECK(b.get(map::driver_temperature) == -55);
    CHECK(b.drive.peek(0x2015) == 0); // a gap
    CHECK(b.drive.peek(0x1FFF) == 0);
    CHECK(b.drive.peek(map::driver_temperature.address) == static_cast<std::uint16_t>(-55));
}

TEST_CASE("torque: a wheel that is driven in reverse and then gets no torque coasts to zero") {
    bench b;
    b.begin(operating_mode::torque);
    b.set(map::left_target_torque, -3000);
    b.run(5000);
    REQUIRE(b.drive.left().speed < 0);
    b.set(map::left_target_torque, 0);
    while (b.drive.left().speed != 0) { // tick by tick: friction does not reverse the wheel
        b.now = b.now + microseconds(250);
        b.drive.on_request(b.now);
        REQUIRE(b.drive.left().speed <= 0);
    }
    CHECK(b.drive.left().current == 0);
    const std::int64_t at = b.drive.left().position;
    b.run(1000);
    CHECK(b.drive.left().position == at);
    b.set(map::left_target_torque, -3000);
    b.run(5000);
    REQUIRE(b.drive.left().speed < 0);
    b.set(map::left_target_torque, 500); // more than the friction: the wheel reverses through zero
    b.run(20'000);
    CHECK(b.drive.left().speed > 0);
}

TEST_CASE("an output may show that both wheels are in position") {
    bench b;
    b.set(map::y0_function, static_cast<int>(map::output_function::in_position));
    b.begin(operating_mode::relative_position);
    CHECK(b.get(map::output_state).y0);
    b.set(map::position_synchronisation, 0);
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        b.set(is_left ? map::left_target_position : map::right_target_position, 2000);
        b.command(is_left ? control_code::start_left : control_code::start_right);
        b.run(10);
        CHECK_FALSE(b.get(map::output_state).y0);
        b.run_until_still();
        CHECK(b.get(map::output_state).y0);
    }
}

TEST_CASE("a brake that closes while the wheels stop blocks its wheel immediately, and the other one "
          "continues") {
    for (const bool is_quick : {false, true}) {
        CAPTURE(is_quick);
        bench b;
        run_at(b, 100);
        b.command(is_quick ? control_code::quick_stop : control_code::stop);
        b.set(map::left_brake, 1);
        b.run(3);
        CHECK(b.drive.left().speed == 0);
        CHECK(b.drive.right().speed > 0);
        b.run_until_still();
        CHECK(b.drive.stands_still());
        CHECK_FALSE(b.drive.enabled());
    }
}

TEST_CASE("in torque and position mode a wheel that is driven against its brake is overloaded") {
    for (const auto m : {operating_mode::torque, operating_mode::relative_position}) {
        CAPTURE(static_cast<int>(m));
        bench b;
        b.set(map::left_brake, 1);
        b.set(map::left_overload_time, 100);
        b.set(map::position_synchronisation, 0);
        b.begin(m);
        b.run(1500);
        CHECK_FALSE(b.get(map::left_faults).any()); // no target drives the wheel
        if (m == operating_mode::torque) b.set(map::left_target_torque, 2000);
        if (m == operating_mode::relative_position) {
            b.set(map::left_target_position, 1000);
            b.command(control_code::start_left);
        }
        b.run(1100);
        CHECK(b.get(map::left_faults).has(fault::overload));
        CHECK(b.drive.left().position == 0);
    }
}

TEST_CASE("0 encoder lines mean 1024") {
    for (const int lines : {1024, 0}) {
        bench b;
        b.set(map::left_encoder_lines, lines);
        run_at(b, 60);
        const std::int64_t at = b.drive.left().position;
        b.run(1000);
        CHECK(about(b.drive.left().position - at, 4096, 5));
    }
}

TEST_CASE("position: a wheel with a target beyond its range does not start, and the other one does") {
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        bench b;
        b.begin(operating_mode::absolute_position);
        b.set(map::position_synchronisation, 1);
        b.set(is_left ? map::left_target_position : map::right_target_position, 0x40000000);
        b.set(is_left ? map::right_target_position : map::left_target_position, 1000);
        b.command(control_code::start_both);
        CHECK(b.drive.starts() == 1);
        CHECK(b.drive.left().starts == (is_left ? 0 : 1));
        CHECK(b.drive.right().starts == (is_left ? 1 : 0));
    }
}

TEST_CASE("the stop input is the terminal with its function: X1, or none") {
    bench b;
    b.set(map::x0_function, 0);
    b.begin(operating_mode::velocity);
    b.drive.set_input(true, true);
    b.run(10);
    CHECK(b.drive.enabled());
    b.drive.set_input(false, false);
    b.set(map::x1_function, static_cast<int>(map::input_function::emergency_stop));
    b.run(10);
    CHECK(b.drive.enabled());
    b.drive.set_input(false, true);
    b.run(10);
    CHECK(b.drive.current_state() == sim::zlac8015d::state::quick_stop);
}

TEST_CASE("07h after a stop by input that has released the shafts leaves them released") {
    bench b;
    b.set(map::input_stop, 1);
    b.set(map::quick_stop_option_code, 7); // immediate
    run_at(b, 100);
    b.drive.set_input(true, false);
    b.run(5);
    REQUIRE(b.drive.left().speed > 90 * one_r_per_min); // the wheel coasts
    b.command(control_code::stop);
    b.run(1);
    CHECK(b.drive.current_state() == sim::zlac8015d::state::idle); // and not slowing down by 2082h
    CHECK(b.drive.left().speed > 90 * one_r_per_min);
}

TEST_CASE("parking mode brakes the wheels of a drive that is not enabled") {
    std::uint32_t took[2]{};
    for (const bool is_parked : {false, true}) {
        bench b;
        b.set(map::parking_mode, is_parked ? 1 : 0);
        b.set(map::disable_option_code, 0);
        run_at(b, 100);
        b.command(control_code::stop);
        took[is_parked ? 1 : 0] = b.run_until_still();
    }
    CHECK(took[1] * 5 < took[0]);
}

} // namespace sim_zlac8015d_states_tests
