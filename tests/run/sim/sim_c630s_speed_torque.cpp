// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated C630S in speed control and in torque control: sources of the commands, ramps, limits, jog,
// and the change of the control mode by inputs.
#include <doctest/doctest.h>

#include <initializer_list>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_speed_torque_tests {

using namespace servobus;
using namespace c630s_bench;

// Speed control

TEST_CASE("in speed control the default of P06-03 moves the motor as soon as it is enabled") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    b.enable();
    b.run(100);
    CHECK(b.drive.speed() == 200 * one_r_per_min);
    CHECK(b.get(map::actual_speed) == 200);
    CHECK(b.get(map::fine_actual_speed) == 2000);
    CHECK(b.get(map::speed_command) == 200);
}

TEST_CASE("a ramp time is for 1000 r/min; limits apply, and outputs show them") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::target_speed, 0);
    b.restart();
    b.enable();
    CHECK(b.drive.is_active(out::zero_speed));
    b.set(map::acceleration_time, 500);
    b.set(map::deceleration_time, 250);
    b.set(map::target_speed, 2000);
    b.run(500);
    CHECK(about(b.drive.speed(), 1000 * one_r_per_min, 4 * one_r_per_min));
    CHECK_FALSE(b.drive.is_active(out::speed_coincidence));
    CHECK(b.drive.is_active(out::rotating));
    b.run(502);
    CHECK(b.drive.speed() == 2000 * one_r_per_min);
    CHECK(b.drive.is_active(out::speed_coincidence));
    CHECK(b.drive.is_active(out::speed_reached));
    CHECK_FALSE(b.drive.is_active(out::zero_speed));
    b.set(map::target_speed, 0);
    b.run(498);
    CHECK_FALSE(b.drive.stands_still());
    b.run(4);
    CHECK(b.drive.stands_still());
    b.set(map::max_reverse_speed, 300);
    b.set(map::target_speed, -1000);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == -300);
    CHECK(b.drive.is_active(out::speed_limited));
    b.set(map::max_speed, 100);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == -100);
}

TEST_CASE("the motor continues without requests on the bus") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    b.enable();
    b.run(600'000);
    CHECK(b.get(map::actual_speed) == 200);
}

TEST_CASE("inputs switch speed commands A and B, their direction and the zero clamp; the commands may be "
          "added") {
    bench b;
    b.assign({in::command_selection, in::speed_direction, in::zero_clamp});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::speed_command_selection, map::command_selection::switched);
    b.restart();
    b.drive.set_analogue(5000, 0); // 1500 r/min by P03-51
    b.enable();
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 200);
    CHECK(b.get(map::ai1_voltage) == 500);
    b.virtual_levels(3);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 1500);
    b.virtual_levels(5);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == -200);
    b.set(map::zero_clamp_threshold, 200);
    b.virtual_levels(9);
    b.run(1000);
    CHECK(b.drive.stands_still());
    b.virtual_levels(0);
    b.run(10);
    b.set(map::speed_command_selection, map::command_selection::sum);
    b.enable();
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 1700);
}

TEST_CASE("speed segments run once, cyclically, or by inputs") {
    const auto prepare = [](bench& b, map::segment_mode mode) {
        b.assign({in::segment_selection_1, in::segment_selection_2, in::segment_direction});
        b.set(map::mode_of_operation, map::control_mode::speed);
        b.set(map::auxiliary_speed_source, map::speed_source::segments);
        b.set(map::speed_command_selection, map::command_selection::auxiliary);
        b.set(map::speed_segment_mode, mode);
        b.set(map::last_speed_segment, 3);
        for (unsigned i = 0; i < 4; ++i) {
            b.set(map::speed_segment_speeds[i], 100 * (static_cast<int>(i) + 1));
            b.set(map::speed_segment_run_times[i], 10);
        }
        b.restart();
        b.enable();
    };
    bench once;
    prepare(once, map::segment_mode::single);
    for (const int wanted : {100, 200, 300, 0, 0}) {
        once.run(500);
        CHECK(once.get(map::actual_speed) == wanted);
        once.run(500);
    }
    bench circle;
    prepare(circle, map::segment_mode::cyclic);
    for (const int wanted : {100, 200, 300, 100, 200}) {
        circle.run(500);
        CHECK(circle.get(map::actual_speed) == wanted);
        circle.run(500);
    }
    bench chosen;
    prepare(chosen, map::segment_mode::by_input);
    chosen.run(5000);
    CHECK(chosen.get(map::actual_speed) == 100);
    chosen.virtual_levels(1 | 6); // segment 4
    chosen.run(100);
    CHECK(chosen.get(map::actual_speed) == 400);
    chosen.virtual_levels(1 | 6 | 8);
    chosen.run(100);
    CHECK(chosen.get(map::actual_speed) == -400);
}

TEST_CASE("jog inputs turn the motor at P06-04 in every mode") {
    for (const auto mode :
         {map::control_mode::speed, map::control_mode::position, map::control_mode::torque}) {
        bench b;
        b.assign({in::jog_forward, in::jog_reverse});
        b.set(map::mode_of_operation, mode);
        b.set(map::target_speed, 0);
        b.restart();
        b.enable();
        b.virtual_levels(3);
        b.run(500);
        CHECK(b.get(map::actual_speed) == 100);
        b.set(map::jog_speed, 300);
        b.virtual_levels(5);
        b.run(500);
        CHECK(b.get(map::actual_speed) == -300);
        b.virtual_levels(1);
        b.run(500);
        CHECK(b.drive.stands_still());
    }
}

// Torque control

TEST_CASE("torque accelerates the motor up to the speed limits") {
    bench b;
    b.assign({in::torque_direction, in::speed_limit_selection});
    b.set(map::mode_of_operation, map::control_mode::torque);
    b.restart();
    b.enable();
    b.run(100);
    CHECK(b.drive.stands_still());
    b.set(map::target_torque, 500);
    b.run(20);
    CHECK(b.drive.torque() == 500);
    CHECK(b.get(map::torque_command) == 500);
    CHECK(b.drive.is_active(out::torque_reached));
    CHECK(about(b.drive.speed(), 20 * 480 * 30'000, 10 * one_r_per_min));
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 3000);
    CHECK(b.drive.is_active(out::speed_limited));
    b.set(map::forward_speed_limit, 1000);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 1000);
    b.virtual_levels(3);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == -3000);
    b.set(map::speed_limit_source, map::speed_limit::by_input);
    b.virtual_levels(5);
    b.run(3000);
    CHECK(b.get(map::actual_speed) == 1000);
    b.set(map::positive_internal_torque_limit, 100);
    b.run(10);
    CHECK(b.drive.torque() == 100);
    CHECK(b.drive.is_active(out::torque_limited));
    b.set(map::target_torque, 0);
    b.run_until_still();
    CHECK(b.drive.stands_still());
}

TEST_CASE("torque limits slow a ramp down") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::target_speed, 3000);
    b.set(map::acceleration_time, 0);
    b.set(map::positive_internal_torque_limit, 200);
    b.restart();
    b.enable();
    b.run(100);
    CHECK(b.drive.is_active(out::torque_limited));
    CHECK(b.drive.speed() < 700 * one_r_per_min);
    CHECK(b.run_until([&] { return b.drive.speed() == 3000 * one_r_per_min; }) < 1000);
}

// Change of mode

TEST_CASE("FunIN.10 and FunIN.11 switch the control mode of an enabled drive") {
    bench b;
    b.assign({in::mode_selection_1, in::mode_selection_2});
    b.set(map::mode_of_operation, map::control_mode::torque_or_speed_or_position);
    b.restart();
    b.enable();
    b.run(500);
    CHECK(b.drive.stands_still()); // torque
    b.virtual_levels(3);
    b.run(500);
    CHECK(b.get(map::actual_speed) == 200);
    b.virtual_levels(5);
    b.run(500);
    CHECK(b.drive.stands_still());
    CHECK(b.drive.is_active(out::positioning_completed));
}

} // namespace sim_c630s_speed_torque_tests
