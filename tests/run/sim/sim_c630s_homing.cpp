// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The homing of the simulated C630S: all modes, the offset, the time limit, how it begins and what ends it.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_homing_tests {

using namespace servobus;
using namespace c630s_bench;

namespace {
// A homing mode of P05-31 on a machine with a switch from 2.5 to 3.5 turns and limits at -10 and 10 turns.
struct homing_bench : bench {
    explicit homing_bench(int mode, std::int64_t home_from = 5 * turn / 2,
                          std::int64_t home_to = 7 * turn / 2)
        : bench{{.homing_command_ends = true}} {
        assign({in::homing_start});
        set(map::di2_function, in::positive_overtravel);
        set(map::di3_function, in::negative_overtravel);
        set(map::di7_function, in::home_switch);
        set(map::homing_method, mode);
        set(map::homing_high_speed, 600);
        set(map::homing_low_speed, 60);
        set(map::homing_acceleration_time, 100);
        set(map::homing_time_limit, 60'000);
        restart();
        set(map::eeprom_update, 0);
        drive.attach({home_from, home_to, -10 * turn, 10 * turn});
        enable();
    }
    bool home() {
        set(map::homing_control, map::homing::start);
        run(2);
        CHECK(drive.is_homing());
        CHECK_FALSE(drive.is_active(out::home_attained));
        run_until([this] { return !drive.is_homing(); }, 70'000);
        CHECK(drive.peek(map::homing_control.address) == 0);
        return drive.is_active(out::home_attained);
    }
};
} // namespace

TEST_CASE("all ten modes of homing find their signal") {
    struct wanted {
        int mode;
        std::int64_t at;
    };
    const wanted forward[] = {{0, 5 * turn / 2}, {2, turn},       {3, 0},        {4, 3 * turn},
                              {6, 10 * turn},    {7, -10 * turn}, {8, 9 * turn}, {9, -9 * turn},
                              {1, 7 * turn / 2}, {5, 3 * turn}};
    for (const wanted& w : forward) {
        CAPTURE(w.mode);
        homing_bench b{w.mode};
        CHECK(b.home());
        CHECK(about(b.drive.position(), w.at, 200));
        CHECK(b.reference() == 0);
        CHECK(b.drive.stands_still());
        CHECK(b.drive.enabled());
        CHECK(b.drive.homings() == 1);
    }
}

TEST_CASE("homing may begin on the switch, and reverses at a limit") {
    homing_bench on{0, -turn, turn};
    CHECK(on.home());
    CHECK(about(on.drive.position(), -turn, 200));
    homing_bench behind{0, -4 * turn, -3 * turn};
    CHECK(behind.home());
    CHECK(about(behind.drive.position(), -4 * turn, 200));
    homing_bench behind_z{4, -7 * turn / 2, -5 * turn / 2};
    CHECK(behind_z.home());
    CHECK(about(behind_z.drive.position(), -3 * turn, 200));
    CHECK_FALSE(behind.drive.has_alarm(0x601));
}

TEST_CASE("the home offset is the position at home, and electrical homing moves to position 0") {
    homing_bench b{0};
    b.virtual_levels(0);
    b.run(5);
    b.set(map::home_offset, -5000);
    b.enable();
    CHECK(b.home());
    CHECK(b.reference() == -5000);
    b.set(map::homing_control, map::homing::start_electrical);
    b.run(2);
    b.run_until([&] { return !b.drive.is_homing(); });
    CHECK(b.drive.is_active(out::electrical_home_attained));
    CHECK(b.reference() == 0);
    CHECK(b.drive.peek(map::homing_control.address) == 0);
}

TEST_CASE("homing that takes longer than P05-35 is Er.601, a warning") {
    homing_bench b{0, 100 * turn, 101 * turn};
    b.virtual_levels(0);
    b.run(5);
    b.set(map::homing_time_limit, 300);
    b.set(map::homing_time_unit, 1);
    b.enable();
    b.set(map::homing_control, map::homing::start);
    b.run(2990);
    CHECK(b.drive.is_homing());
    b.run(100);
    CHECK_FALSE(b.drive.is_homing());
    CHECK(b.drive.has_alarm(0x601));
    CHECK_FALSE(b.drive.is_active(out::home_attained));
    CHECK(b.drive.enabled());
    CHECK(b.drive.stands_still());
}

TEST_CASE("P05-30: 6 sets home immediately, 1 and 2 wait for the input, 3 homes after power-on, 0 aborts") {
    for (const bool ends : {true, false}) {
        bench b{{.homing_command_ends = ends}};
        b.begin_segments(map::segment_mode::single, {in::homing_start});
        b.start();
        b.run_until_still();
        CHECK(b.reference() == 10'000);
        b.set(map::homing_control, map::homing::set_home);
        CHECK(b.reference() == 0);
        CHECK(b.get(map::homing_control) == (ends ? map::homing::off : map::homing::set_home));
        CHECK(b.drive.in_force(map::homing_control.address) == (ends ? 0 : 6));
        b.start(); // the same value is a command again, or is none [C80]
        b.run_until_still();
        b.set(map::homing_control, map::homing::set_home);
        CHECK((b.reference() == 0) == ends);
        b.set(map::homing_control, map::homing::off);
        b.set(map::homing_control, map::homing::set_home);
        CHECK(b.reference() == 0);
    }

    homing_bench by_input{0};
    by_input.set(map::homing_control, map::homing::by_input);
    by_input.run(100);
    CHECK_FALSE(by_input.drive.is_homing());
    by_input.virtual_levels(3);
    by_input.run(2);
    CHECK(by_input.drive.is_homing());
    by_input.set(map::homing_control, map::homing::off);
    by_input.run(300);
    CHECK_FALSE(by_input.drive.is_homing());
    CHECK(by_input.drive.stands_still());
    by_input.set(map::homing_control, map::homing::electrical_by_input);
    by_input.virtual_levels(1);
    by_input.virtual_levels(3);
    by_input.run(2000);
    CHECK(by_input.drive.is_active(out::electrical_home_attained));

    homing_bench at_power_on{0};
    at_power_on.virtual_levels(0);
    at_power_on.run(5);
    at_power_on.set(map::eeprom_update, 1);
    at_power_on.set(map::eeprom_update, 1);
    at_power_on.set(map::homing_control, map::homing::at_power_on);
    at_power_on.run(100);
    CHECK_FALSE(at_power_on.drive.is_homing());
    at_power_on.restart();
    at_power_on.enable();
    at_power_on.run(2);
    CHECK(at_power_on.drive.is_homing());
    CHECK(at_power_on.get(map::homing_control) == map::homing::at_power_on);
}

TEST_CASE("FunIN.38 on a real input makes the current position home") {
    bench b;
    b.set(map::di8_function, in::set_home);
    b.set(map::homing_control, map::homing::set_home_by_input);
    b.run(2);
    b.drive.set_input(8, true);
    b.run(2);
    CHECK(b.drive.is_active(out::home_attained));
}

TEST_CASE("a stored homing command does not begin by itself; a commanded one waits for S-ON") {
    bench b;
    b.assign({});
    b.restart();
    b.set(map::homing_control, map::homing::start);
    CHECK(b.drive.stored(map::homing_control.address) == 4);
    b.run(100);
    CHECK_FALSE(b.drive.is_homing());
    CHECK(b.get(map::homing_control) == map::homing::start);
    b.enable();
    b.run(5);
    CHECK(b.drive.is_homing());
    b.restart();
    CHECK(b.get(map::homing_control) == map::homing::off);
    b.enable();
    b.run(50);
    CHECK_FALSE(b.drive.is_homing());
}

TEST_CASE("electrical homing ends at a limit switch with Er.601") {
    bench b;
    b.begin_segments(map::segment_mode::single, {in::negative_overtravel});
    b.start();
    b.run_until_still();
    b.virtual_levels(5);
    b.set(map::homing_control, map::homing::start_electrical);
    b.run(10);
    CHECK(b.drive.has_alarm(0x601));
    CHECK(b.drive.position() == turn);
}

TEST_CASE("a jog ends a homing, and after a power cycle the motor coasts") {
    homing_bench b{0};
    b.virtual_levels(0);
    b.run(2);
    b.set(map::virtual_input_functions[1], in::jog_reverse);
    b.set(map::virtual_input_logics[1], 0);
    b.run(2);
    b.enable();
    b.set(map::homing_control, map::homing::start);
    b.run(100);
    CHECK(b.drive.is_homing());
    b.virtual_levels(3);
    b.run(1000);
    CHECK_FALSE(b.drive.is_homing());
    CHECK(b.get(map::actual_speed) == -100);
    b.restart();
    CHECK_FALSE(b.drive.enabled());
    CHECK_FALSE(b.drive.stands_still());
    CHECK(b.run_until_still() > 20);
    CHECK_FALSE(b.drive.enabled());
}

} // namespace sim_c630s_homing_tests
