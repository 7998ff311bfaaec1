// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated C630S in position control: steps, segments, pulses, the gear, a blocked shaft, and when a move
// is complete.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_position_tests {

using namespace servobus;
using namespace c630s_bench;

TEST_CASE("a step moves by P05-05 with each edge of FunIN.20") {
    bench b;
    b.assign({in::step_enable, in::position_direction, in::position_command_inhibit});
    b.set(map::position_command_source, map::position_source::step);
    b.set(map::position_step, 2500);
    b.restart();
    b.start(); // S-ON and the edge come together: the edge is lost
    b.run(500);
    CHECK(b.drive.position() == 0);
    b.start();
    b.run_until_still();
    CHECK(b.drive.position() == turn / 4);
    CHECK(b.reference() == 2500);
    CHECK(b.drive.starts() == 1);
    b.virtual_levels(3);
    b.run(500);
    CHECK(b.drive.position() == turn / 2);
    b.virtual_levels(3); // a level that stays is no edge
    b.run(500);
    CHECK(b.drive.position() == turn / 2);
    b.virtual_levels(1);
    b.start(4);
    b.run_until_still();
    CHECK(b.drive.position() == turn / 4);
    b.start(8);
    b.run(500);
    CHECK(b.drive.position() == turn / 4); // inhibited
}

TEST_CASE("a segment that inputs select is moved once for each edge") {
    bench b;
    b.begin_segments(map::segment_mode::by_input, {in::segment_selection_1, in::segment_selection_2});
    CHECK(b.drive.is_active(out::positioning_completed));
    b.set(map::position_segment_displacements[2], 80'000);
    b.set(map::position_segment_speeds[2], 3000);
    b.set(map::position_segment_acceleration_times[2], 1000);
    b.virtual_levels(1 | 8);
    b.start(8);
    b.run(1);
    CHECK(b.drive.is_active(out::positioning_completed)); // still active, easily misread
    b.run(20);
    CHECK_FALSE(b.drive.is_active(out::positioning_completed));
    CHECK(b.get(map::following_error) > 0);
    b.start(8); // lost
    b.run_until_still();
    CHECK(b.drive.position() == 8 * turn);
    CHECK(b.reference() == 80'000);
    CHECK(b.get(map::feedback_pulses) == 8 * turn);
    CHECK(b.get(map::command_pulses) == 80'000);
    CHECK(b.drive.is_active(out::positioning_completed));
    CHECK(b.drive.is_active(out::positioning_near));
    CHECK(b.drive.starts() == 1);
    b.run(1000);
    CHECK(b.drive.position() == 8 * turn);
    b.start(8);
    b.run_until_still();
    CHECK(b.drive.position() == 16 * turn);
}

TEST_CASE("segments run once, cyclically or from P11-05, relative or absolute, with wait times") {
    bench once;
    once.set(map::last_position_segment, 3);
    once.begin_segments(map::segment_mode::single);
    once.set(map::position_segment_wait_times[0], 300);
    once.start();
    once.run_until([&] { return once.drive.position() == turn; });
    once.run(299);
    CHECK(once.drive.position() == turn);
    once.run_until_still();
    CHECK(once.drive.position() == 3 * turn);
    once.run(2000);
    CHECK(once.drive.position() == 3 * turn);

    bench circle;
    circle.set(map::last_position_segment, 2);
    circle.begin_segments(map::segment_mode::cyclic);
    circle.set(map::position_segment_displacements[1], -10'000);
    circle.start();
    circle.run_until([&] { return circle.drive.position() == turn; });
    circle.run_until([&] { return circle.drive.position() == 0; });
    circle.run_until([&] { return circle.drive.position() == turn; });
    CHECK(circle.drive.position() == turn);
    CHECK(circle.drive.is_positioning());

    bench from;
    from.set(map::last_position_segment, 3);
    from.set(map::first_position_segment, 2);
    from.begin_segments(map::segment_mode::sequential);
    from.start();
    from.run_until_still();
    CHECK(from.drive.position() == 2 * turn);

    bench absolute;
    absolute.set(map::position_segment_type, map::displacement_type::absolute);
    absolute.begin_segments(map::segment_mode::single, {in::position_direction});
    absolute.set(map::position_segment_displacements[0], 30'000);
    for (int i = 0; i < 2; ++i) {
        absolute.start();
        absolute.run_until_still();
        CHECK(absolute.drive.position() == 3 * turn);
    }
    absolute.virtual_levels(5);
    absolute.start(4);
    absolute.run_until_still();
    CHECK(absolute.drive.position() == -3 * turn);
}

TEST_CASE("P11-02 defines whether an interrupted run is finished or restarted") {
    for (const auto how : {map::segment_remainder::finish, map::segment_remainder::restart}) {
        bench b;
        b.set(map::last_position_segment, 2);
        b.set(map::position_segment_remainder, how);
        b.begin_segments(map::segment_mode::single, {in::position_command_inhibit});
        b.start();
        b.run(100);
        b.virtual_levels(5);
        b.run(500);
        const std::int64_t halfway = b.drive.position();
        CHECK(halfway > 0);
        CHECK(halfway < turn);
        b.virtual_levels(1);
        b.run(500);
        CHECK(b.drive.position() == halfway);
        b.start();
        b.run_until_still();
        CHECK(about(b.drive.position(), how == map::segment_remainder::finish ? 2 * turn : halfway + 2 * turn,
                    500));
    }
}

TEST_CASE("the speed of a segment follows P11-14 and P11-15") {
    bench b;
    b.begin_segments(map::segment_mode::single);
    b.set(map::position_segment_displacements[0], 1'000'000);
    b.set(map::position_segment_speeds[0], 1000);
    b.set(map::position_segment_acceleration_times[0], 500);
    b.start();
    b.run(249);
    CHECK(about(b.drive.speed(), 500 * one_r_per_min, 5 * one_r_per_min));
    b.run(1000);
    CHECK(b.get(map::actual_speed) == 1000);
    CHECK(b.get(map::position_command_speed) == 1000);
    CHECK(about(b.run_until_still(), 6500 - 1251, 40)); // 100 turns at 1000 r/min and half a second more
    CHECK(b.drive.position() == 100 * turn);
}

TEST_CASE("the gear is P05-02 or one of two ratios") {
    bench b;
    b.set(map::pulses_per_revolution, 0);
    b.begin_segments(map::segment_mode::single, {in::gear_selection});
    b.start();
    b.run_until_still();
    CHECK(b.drive.position() == 8 * turn); // 2^20 counts for 10000 units: 1250 units per turn
    CHECK(b.reference() == 10'000);
    b.set(map::gear_2_numerator, 131'072);
    b.virtual_levels(5);
    b.run(2);
    b.start(4);
    b.run_until_still();
    CHECK(b.drive.position() == 9 * turn);
}

TEST_CASE("pulses move the motor unless they are inhibited") {
    bench b;
    b.assign({in::pulse_inhibit});
    b.restart();
    b.drive.send_pulses(100);
    b.enable();
    b.drive.send_pulses(5000);
    b.run(100);
    CHECK(b.drive.position() == turn / 2);
    b.virtual_levels(3);
    b.run(1);
    b.drive.send_pulses(5000);
    b.run(100);
    CHECK(b.drive.position() == turn / 2);
}

TEST_CASE("a blocked shaft causes a deviation, Er.630 or Er.B00; FunIN.35 clears the deviation") {
    bench b;
    b.set(map::stall_protection, 0);
    b.begin_segments(map::segment_mode::single, {in::clear_following_error});
    b.drive.block_shaft(true);
    b.start();
    b.run(2000);
    CHECK(b.get(map::following_error) == 10'000);
    CHECK(b.get(map::encoder_following_error) == turn);
    CHECK_FALSE(b.drive.is_active(out::positioning_completed));
    b.virtual_levels(5);
    b.run(2);
    CHECK(b.get(map::following_error) == 0);
    b.drive.block_shaft(false);
    b.run(100);
    CHECK(b.drive.position() == 0);
    b.drive.block_shaft(true);
    b.set(map::following_error_limit, 50'000);
    b.virtual_levels(1);
    b.start();
    b.run(2000);
    CHECK(b.drive.has_alarm(0xB00));
    CHECK_FALSE(b.drive.enabled());

    bench stalled;
    stalled.begin_segments(map::segment_mode::single);
    stalled.drive.block_shaft(true);
    stalled.start();
    stalled.run(190);
    CHECK_FALSE(stalled.drive.has_fault());
    stalled.run(30);
    CHECK(stalled.drive.has_alarm(0x630));
}

TEST_CASE("P05-20 sets the condition of COIN") {
    for (const int condition : {0, 1, 2, 3}) {
        bench b;
        b.begin_segments(map::segment_mode::single);
        b.set(map::positioning_completed_condition, condition);
        b.set(map::positioning_completed_hold_time, 50);
        b.set(map::position_segment_speeds[0], 10);
        b.run(1);
        b.start();
        b.run(20); // at 10 r/min the deviation is below P05-21
        CHECK(b.drive.is_active(out::positioning_completed) == (condition == 0 || condition == 3));
        b.run(100);
        CHECK(b.drive.is_active(out::positioning_completed) == (condition == 0));
        b.run_until_still();
        CHECK(b.drive.is_active(out::positioning_completed));
    }
}

TEST_CASE("two equal runs give the same result") {
    const auto play = [] {
        bench b;
        b.begin_segments(map::segment_mode::cyclic);
        b.start();
        b.run(12'345);
        return b.drive.position();
    };
    CHECK(play() == play());
}

} // namespace sim_c630s_position_tests
