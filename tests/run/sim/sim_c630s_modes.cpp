// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated C630S in every control mode: the sources of its commands and limits, how a blocked shaft or a
// limit switch changes them, and how homing continues then. Sections 6.1 to 6.3, 7.5 to 7.7.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <vector>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_modes_tests {

using namespace servobus;
using namespace c630s_bench;

namespace {

/// A disabled drive that is set up for this control mode.
bench in_mode(map::control_mode mode, const std::vector<in>& inputs = {}) {
    bench b;
    b.set(map::stall_protection, 0);
    b.assign(inputs);
    b.set(map::mode_of_operation, mode);
    b.restart();
    b.set(map::eeprom_update, 0);
    return b;
}
void disable(bench& b) {
    b.virtual_levels(0);
    b.run_until_still();
    b.run(2);
    REQUIRE(b.drive.current_state() == sim::c630s::state::off);
}

} // namespace

// Speed

TEST_CASE("AI2 can be the source of the speed, and the zero clamp does not stop a faster command") {
    bench b = in_mode(map::control_mode::speed, {in::zero_clamp});
    b.set(map::auxiliary_speed_source, map::speed_source::ai2);
    b.set(map::speed_command_selection, map::command_selection::auxiliary);
    b.set(map::zero_clamp_threshold, 100);
    b.drive.set_analogue(5000, -1000); // 3000 r/min at 10 V
    b.enable(2);
    b.run(1000);
    CHECK(b.get(map::actual_speed) == -300);
    CHECK(b.get(map::ai2_voltage) == -100);
    b.drive.set_analogue(5000, -333);
    b.run(1000);
    CHECK(b.drive.stands_still()); // 99.9 r/min
}

TEST_CASE("four inputs select one of sixteen speed segments; their times may be in minutes") {
    const auto prepare = [](bench& b, map::segment_mode mode) {
        b.set(map::auxiliary_speed_source, map::speed_source::segments);
        b.set(map::speed_command_selection, map::command_selection::auxiliary);
        b.set(map::speed_segment_mode, mode);
        for (unsigned i = 0; i < 16; ++i) {
            b.set(map::speed_segment_speeds[i], 10 * (static_cast<int>(i) + 1));
            b.set(map::speed_segment_run_times[i], 1);
        }
    };
    bench chosen = in_mode(map::control_mode::speed, {in::segment_selection_1, in::segment_selection_2,
                                                      in::segment_selection_3, in::segment_selection_4});
    prepare(chosen, map::segment_mode::by_input);
    chosen.enable();
    for (unsigned i = 0; i < 16; ++i) {
        chosen.virtual_levels(1u | i << 1);
        chosen.run(500);
        CHECK(chosen.get(map::actual_speed) == 10 * (static_cast<int>(i) + 1));
    }
    bench slow = in_mode(map::control_mode::speed);
    prepare(slow, map::segment_mode::single);
    slow.set(map::speed_segment_time_unit, map::speed_time_unit::minutes);
    slow.set(map::last_speed_segment, 2);
    slow.enable();
    for (const int wanted : {10, 20, 0}) { // 0.1 min each
        slow.run(5900);
        CHECK(slow.get(map::actual_speed) == wanted);
        slow.run(100);
    }
    bench timeless = in_mode(map::control_mode::speed);
    prepare(timeless, map::segment_mode::cyclic);
    for (unsigned i = 0; i < 16; ++i) {
        timeless.set(map::speed_segment_speeds[i], 70);
        timeless.set(map::speed_segment_run_times[i], 0);
    }
    timeless.enable();
    timeless.run(500);
    CHECK(timeless.get(map::actual_speed) == 70);
    disable(timeless);
    timeless.set(map::speed_segment_speeds[15], 160);
    timeless.set(map::speed_segment_run_times[15], 10);
    timeless.virtual_levels(1);
    timeless.run(1);
    CHECK(timeless.get(map::speed_command) == 160); // those without a time are skipped immediately
}

TEST_CASE("a blocked shaft gets the full torque of its limit, and none at a speed of zero") {
    bench b = in_mode(map::control_mode::speed);
    b.set(map::positive_internal_torque_limit, 700);
    b.set(map::negative_internal_torque_limit, 400);
    b.drive.block_shaft(true);
    b.set(map::target_speed, 100);
    b.enable();
    b.run(10);
    CHECK(b.drive.torque() == 700);
    CHECK(b.drive.is_active(out::torque_limited));
    b.set(map::target_speed, -100);
    b.run(10);
    CHECK(b.drive.torque() == -400);
    b.set(map::target_speed, 0);
    b.run(10);
    CHECK(b.drive.torque() == 0);
    CHECK_FALSE(b.drive.is_active(out::torque_limited));
    CHECK(b.drive.position() == 0);
}

TEST_CASE("with a torque limit below the friction a motor coasts to standstill, in both directions") {
    for (const int direction : {1, -1}) {
        bench b = in_mode(map::control_mode::speed);
        b.set(map::target_speed, 300 * direction);
        b.enable();
        b.run(1000);
        REQUIRE(b.get(map::actual_speed) == 300 * direction);
        b.set(map::positive_internal_torque_limit, 0);
        b.set(map::negative_internal_torque_limit, 0);
        for (int i = 0; i < 2000; ++i) {
            b.run(1);
            REQUIRE(b.drive.speed() * direction >= 0); // friction does not reverse the motor
        }
        CHECK(b.drive.enabled());
        CHECK(b.drive.stands_still());
        CHECK(b.drive.torque() == 0);
    }
}

// Torque

TEST_CASE("P07-07 selects internal, external or analogue torque limits, with P-CL and N-CL") {
    struct limits {
        map::torque_limit from;
        int forward, reverse;                   // without an input
        int selected_forward, selected_reverse; // with P-CL and N-CL
    };
    const limits all[] = {{map::torque_limit::internal, 2000, 1500, 2000, 1500},
                          {map::torque_limit::external, 2000, 1500, 400, 250},
                          {map::torque_limit::analogue, 300, 300, 300, 300},
                          {map::torque_limit::external_or_analogue, 300, 300, 300, 250},
                          {map::torque_limit::internal_or_analogue, 2000, 1500, 300, 300}};
    bench b = in_mode(map::control_mode::speed, {in::positive_torque_limit, in::negative_torque_limit});
    b.set(map::positive_internal_torque_limit, 2000);
    b.set(map::negative_internal_torque_limit, 1500);
    b.set(map::positive_external_torque_limit, 400);
    b.set(map::negative_external_torque_limit, 250);
    b.drive.set_analogue(0, -3000); // AI2 by default; rated torque at 10 V, and its sign has no effect
    b.drive.block_shaft(true);
    for (const limits& l : all) {
        CAPTURE(static_cast<int>(l.from));
        disable(b);
        b.set(map::torque_limit_source, l.from);
        for (const bool is_selected : {false, true}) {
            CAPTURE(is_selected);
            b.enable(is_selected ? 6 : 0);
            b.set(map::target_speed, 100);
            b.run(2);
            CHECK(b.drive.torque() == (is_selected ? l.selected_forward : l.forward));
            b.set(map::target_speed, -100);
            b.run(2);
            CHECK(b.drive.torque() == -(is_selected ? l.selected_reverse : l.reverse));
        }
    }
}

TEST_CASE(
    "torque commands A and B are digital or voltages; P07-02 selects A, B, their sum or FunIN.4, and never "
    "the bus") {
    bench b = in_mode(map::control_mode::torque, {in::command_selection});
    b.drive.block_shaft(true);
    b.drive.set_analogue(3000, -2000);
    const auto given = [&](map::torque_source a, map::torque_source other, map::command_selection how,
                           bool is_switched = false) {
        disable(b);
        b.set(map::main_torque_source, a);
        b.set(map::auxiliary_torque_source, other);
        b.set(map::torque_command_selection, how);
        b.set(map::target_torque, 70);
        b.enable(is_switched ? 2 : 0);
        b.run(2);
        return b.drive.torque();
    };
    using from = map::torque_source;
    using by = map::command_selection;
    CHECK(given(from::digital, from::ai2, by::main) == 70);
    CHECK(given(from::ai1, from::ai2, by::main) == 300);
    CHECK(given(from::ai1, from::ai2, by::auxiliary) == -200);
    CHECK(given(from::ai1, from::ai2, by::sum) == 100);
    CHECK(given(from::ai1, from::ai2, by::switched) == 300);
    CHECK(given(from::ai1, from::ai2, by::switched, true) == -200);
    CHECK(given(from::ai2, from::digital, by::sum) == -130);
    CHECK(given(from::ai1, from::ai2, by::bus) == 0);
}

TEST_CASE("P07-17: in torque control a voltage limits the speed, or FunIN.36 selects the limit") {
    bench b = in_mode(map::control_mode::torque, {in::speed_limit_selection});
    b.set(map::forward_speed_limit, 800);
    b.set(map::reverse_speed_limit, 500);
    b.set(map::speed_limit_source, map::speed_limit::analogue);
    b.drive.set_analogue(-2000, 0); // AI1: 600 r/min, either way
    b.set(map::target_torque, 300);
    b.enable();
    b.run(2000);
    CHECK(b.get(map::actual_speed) == 600);
    CHECK(b.drive.is_active(out::speed_limited));
    b.set(map::target_torque, -300);
    b.run(3000);
    CHECK(b.get(map::actual_speed) == -600);
    b.set(map::speed_limit_source, map::speed_limit::by_input);
    b.run(2000);
    CHECK(b.get(map::actual_speed) == -500); // P07-20 without it
    b.virtual_levels(3);
    b.run(2000);
    CHECK(b.get(map::actual_speed) == -800); // P07-19
}

TEST_CASE("in torque control a limit switch blocks its direction and allows the other") {
    for (const bool is_positive : {true, false}) {
        bench b = in_mode(map::control_mode::torque,
                          {is_positive ? in::positive_overtravel : in::negative_overtravel});
        b.set(map::stop_at_overtravel, map::overtravel_stop::zero_speed_and_lock);
        const int way = is_positive ? 1 : -1;
        b.enable(2);
        b.set(map::target_torque, 200 * way);
        b.run(500);
        CHECK(b.drive.stands_still());
        CHECK(b.drive.position() == 0);
        b.set(map::target_torque, -200 * way);
        b.run(500);
        CHECK(b.drive.speed() * way < 0);
    }
}

// Control modes that inputs switch

TEST_CASE("FunIN.10 switches between the two modes of P02-00 = 3, 4 and 5: the second one while it is "
          "active") {
    struct pair {
        map::control_mode of;
        map::control_mode without, with;
    };
    using mode = map::control_mode;
    const pair pairs[] = {{mode::torque_or_speed, mode::torque, mode::speed},
                          {mode::speed_or_position, mode::speed, mode::position},
                          {mode::torque_or_position, mode::torque, mode::position}};
    for (const pair& p : pairs) {
        CAPTURE(static_cast<int>(p.of));
        bench b = in_mode(p.of, {in::mode_selection_1, in::step_enable});
        b.set(map::position_command_source, map::position_source::step);
        b.set(map::target_speed, 100);
        b.set(map::target_torque, 0);
        b.enable();
        for (const bool is_active : {false, true, false}) {
            const unsigned level = is_active ? 2 : 0;
            b.virtual_levels(1 | level);
            b.run(500);
            const mode wanted = is_active ? p.with : p.without;
            CHECK((b.drive.speed() == 100 * one_r_per_min) == (wanted == mode::speed));
            // A step is made in position control only.
            const std::uint32_t before = b.drive.starts();
            b.virtual_levels(1 | level | 4);
            b.run(2);
            CHECK(b.drive.starts() - before == (wanted == mode::position ? 1 : 0));
            b.run(1000);
        }
    }
}

// Positions

TEST_CASE("edges and pulses of a source that P05-00 does not select move nothing") {
    bench b = in_mode(map::control_mode::position, {in::step_enable, in::position_segment_start});
    const auto all_at_once = [&](map::position_source from) {
        disable(b);
        b.set(map::position_command_source, from);
        b.enable();
        const std::int64_t before = b.drive.position();
        b.drive.send_pulses(1000);
        b.virtual_levels(1 | 2 | 4);
        b.run_until_still();
        return b.drive.position() - before;
    };
    b.set(map::position_step, 20);
    b.set(map::position_segment_mode, map::segment_mode::by_input);
    b.set(map::position_segment_displacements[0], 3000);
    const auto counts = [](int units) { return std::int64_t{units} * turn / 10'000; };
    CHECK(about(all_at_once(map::position_source::pulses), counts(1000), 1));
    CHECK(about(all_at_once(map::position_source::step), counts(20), 1));
    CHECK(about(all_at_once(map::position_source::segments), counts(3000), 1));
    disable(b);
    b.set(map::position_command_source, map::position_source::pulses);
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::target_speed, 0);
    b.enable();
    const std::int64_t there = b.drive.position();
    b.drive.send_pulses(1000);
    b.run(500);
    CHECK(b.drive.position() == there);
}

TEST_CASE("pulses add up while the motor moves; FunIN.13 inhibits them") {
    bench b = in_mode(map::control_mode::position, {in::position_command_inhibit});
    b.set(map::position_command_source, map::position_source::pulses);
    b.enable();
    b.drive.send_pulses(50'000);
    b.run(20);
    REQUIRE(b.drive.position() < 5 * turn);
    b.drive.send_pulses(50'000);
    b.run_until_still();
    CHECK(b.drive.position() == 10 * turn);
    b.virtual_levels(3);
    b.run(1);
    b.drive.send_pulses(50'000);
    b.run(500);
    CHECK(b.drive.position() == 10 * turn);
}

TEST_CASE("P11-03 sets seconds as the unit of a segment's times") {
    bench b;
    b.begin_segments(map::segment_mode::single);
    disable(b);
    b.set(map::position_segment_time_unit, map::position_time_unit::seconds);
    b.set(map::last_position_segment, 2);
    for (unsigned i = 0; i < 2; ++i) {
        b.set(map::position_segment_displacements[i], 10'000);
        b.set(map::position_segment_acceleration_times[i], 0);
    }
    b.set(map::position_segment_wait_times[0], 2);
    b.enable();
    b.start();
    b.run_until([&] { return b.drive.position() == turn; });
    b.run(1990);
    CHECK(b.drive.position() == turn);
    b.run_until_still();
    CHECK(b.drive.position() == 2 * turn);
}

TEST_CASE("P05-39: the second gear takes effect immediately, or when the command has ended") {
    for (const auto when : {map::gear_switching::at_once, map::gear_switching::at_zero_command}) {
        bench b;
        b.set(map::pulses_per_revolution, 0);
        b.set(map::gear_switching_condition, when);
        b.begin_segments(map::segment_mode::single, {in::gear_selection});
        b.set(map::gear_2_numerator, 131'072);
        b.set(map::position_segment_speeds[0], 60);
        b.start();
        b.run(100);
        const auto before = b.reference();
        b.virtual_levels(5);
        b.run(2);
        const bool is_at_once = when == map::gear_switching::at_once;
        CHECK((b.reference() > 7 * before) == is_at_once); // what was eight turns is now one
    }
}

TEST_CASE("FunIN.35 without a deviation changes nothing") {
    bench b;
    b.begin_segments(map::segment_mode::single, {in::clear_following_error});
    b.virtual_levels(1 | 4);
    b.run(10);
    CHECK(b.drive.position() == 0);
    CHECK(b.get(map::following_error) == 0);
    b.start(4);
    b.run_until_still();
    CHECK(b.drive.position() == turn);
}

TEST_CASE("a shaft that is unblocked catches up with its command in both directions, no faster than P06-07") {
    for (const int way : {1, -1}) {
        bench b;
        b.set(map::stall_protection, 0);
        b.set(map::following_error_limit, 1'000'000'000);
        b.begin_segments(map::segment_mode::single);
        b.set(map::position_segment_displacements[0], 50'000 * way);
        b.set(map::position_segment_speeds[0], 3000);
        b.drive.block_shaft(true);
        b.start();
        b.run(2000);
        REQUIRE(b.drive.position() == 0);
        CHECK(b.drive.torque() * way > 0); // towards its target
        CHECK(b.drive.is_active(out::torque_limited));
        b.drive.block_shaft(false);
        b.run(20);
        CHECK(b.drive.speed() == b.drive.in_force(map::max_speed.address) * one_r_per_min * way);
        b.run_until_still();
        CHECK(b.drive.position() == 5 * turn * way);
    }
}

TEST_CASE("if a stop ends the move of a blocked shaft, its command becomes its position") {
    for (const bool is_jog : {false, true}) {
        bench b;
        b.set(map::stall_protection, 0);
        b.begin_segments(map::segment_mode::single, {in::emergency_stop, in::jog_forward});
        b.set(map::following_error_limit, 1'000'000'000);
        b.set(map::jog_speed, 0);
        b.drive.block_shaft(true);
        b.start();
        b.run(50);
        REQUIRE(b.get(map::encoder_following_error) != 0);
        b.virtual_levels(is_jog ? 9 : 5);
        b.run(2);
        CHECK(b.get(map::encoder_following_error) == 0);
        b.drive.block_shaft(false);
        b.run(500);
        CHECK(b.drive.position() == 0);
    }
}

TEST_CASE("P0A-17: the deviation limit of Er.B00 is in encoder counts or in reference units") {
    for (const auto node_address : {map::position_unit::encoder, map::position_unit::reference}) {
        bench b;
        b.set(map::stall_protection, 0);
        b.set(map::position_setting_unit, node_address);
        b.set(map::following_error_limit, 20'000); // two turns in units, a seventh of one in counts
        b.begin_segments(map::segment_mode::single);
        b.drive.block_shaft(true);
        b.start();
        b.run(1000);
        CHECK(b.drive.has_alarm(0xB00) == (node_address == map::position_unit::encoder));
    }
}

TEST_CASE("P05-20 = 3: COIN ends because of the deviation after P05-60") {
    bench b;
    b.begin_segments(map::segment_mode::single);
    b.set(map::positioning_completed_condition, map::completed_condition::deviation_held);
    b.set(map::positioning_completed_hold_time, 50);
    b.set(map::position_segment_displacements[0], 100'000);
    b.set(map::position_segment_speeds[0], 3000);
    b.run(1);
    b.start();
    b.run(40);
    CHECK(b.get(map::following_error) > b.drive.in_force(map::positioning_completed_threshold.address));
    CHECK(b.drive.is_active(out::positioning_completed));
    b.run(30);
    CHECK_FALSE(b.drive.is_active(out::positioning_completed));
    b.run_until_still();
    CHECK(b.drive.is_active(out::positioning_completed));
}

// Homing

namespace {
/// Homing with the method `mode`; the limit switches are on DI2 and DI3.
struct searching : bench {
    searching(int mode, std::int64_t negative_limit, std::int64_t positive_limit) {
        assign({in::homing_start});
        set(map::di2_function, in::positive_overtravel);
        set(map::di3_function, in::negative_overtravel);
        set(map::di8_function, in::set_home);
        set(map::homing_method, mode);
        set(map::homing_high_speed, 600);
        set(map::homing_low_speed, 60);
        set(map::homing_acceleration_time, 100);
        set(map::homing_time_limit, 60'000);
        restart();
        set(map::eeprom_update, 0);
        drive.attach({100 * turn, 101 * turn, negative_limit, positive_limit});
    }
    void search() {
        enable();
        set(map::homing_control, map::homing::start);
        run(2);
        REQUIRE(drive.is_homing());
        run_until([this] { return !drive.is_homing(); }, 70'000);
    }
};
} // namespace

TEST_CASE("homing on Z that first meets a limit reverses and uses the next Z") {
    // with the second limit the motor passes a Z while it stops
    for (const std::int64_t limit : {turn / 2, turn - turn / 20}) {
        CAPTURE(limit);
        searching b{2, -10 * turn, limit};
        b.search();
        CHECK(b.drive.is_active(out::home_attained));
        CHECK(b.drive.position() == (limit == turn / 2 ? 0 : turn));
        CHECK(b.reference() == 0);
        CHECK_FALSE(b.drive.has_alarm(0x601));
    }
}

TEST_CASE("homing between two active limits ends at its time limit with Er.601") {
    searching b{0, 2 * turn, turn / 2};
    b.set(map::homing_time_limit, 3000);
    b.search();
    CHECK(b.drive.has_alarm(0x601));
    CHECK_FALSE(b.drive.is_active(out::home_attained));
    CHECK(b.drive.stands_still());
    CHECK(b.drive.position() < turn);
}

TEST_CASE("homing on Z continues after a blocked shaft is released, and ignores every Z that it passes while "
          "reversing") {
    searching b{2, -100 * turn, 100 * turn};
    b.set(map::following_error_limit, 1'000'000'000);
    b.set(map::stall_protection, 0);
    b.set(map::homing_low_speed, 600);
    b.set(map::homing_acceleration_time, 1000);
    b.enable();
    b.set(map::homing_control, map::homing::start);
    b.run_until([&] { return b.drive.speed() < 0; }); // it moves back from the first Z
    b.drive.block_shaft(true);
    b.run(1000); // several turns
    b.drive.block_shaft(false);
    b.run_until([&] { return !b.drive.is_homing(); });
    CHECK(b.drive.is_active(out::home_attained));
    CHECK(b.drive.position() % turn == 0);
    CHECK(b.drive.position() < 0);
    CHECK(b.reference() == 0);
}

TEST_CASE("P05-61 = 2 sets tenths of a second as the unit of the homing time limit") {
    searching b{0, -1000 * turn, 1000 * turn};
    b.set(map::homing_time_limit, 20);
    b.set(map::homing_time_unit, 2);
    b.enable();
    b.set(map::homing_control, map::homing::start);
    b.run(1990);
    CHECK(b.drive.is_homing());
    b.run(20);
    CHECK_FALSE(b.drive.is_homing());
    CHECK(b.drive.has_alarm(0x601));
}

TEST_CASE("the edges of FunIN.32 and FunIN.38 act as P05-30 defines, the first only with the servo on") {
    searching b{0, -10 * turn, 10 * turn};
    b.drive.set_input(8, true); // set home, while P05-30 is 0
    b.run(10);
    CHECK_FALSE(b.drive.is_active(out::home_attained));
    b.set(map::homing_control, map::homing::by_input);
    b.virtual_levels(2);
    b.run(10);
    b.virtual_levels(0);
    b.enable();
    b.run(10);
    CHECK(b.drive.homings() == 0); // the edge came while it was off
    b.virtual_levels(3);
    b.run(10);
    CHECK(b.drive.homings() == 1);
}

} // namespace sim_c630s_modes_tests
