// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Interpretations of the ZLAC8015D manual to which the simulated drive can be switched: what the running bits say of
// wheels without power, and which wheel a fault switches off. Each is compared with its comment in
// sim/zlac8015d/options.hpp.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_interpretations_tests {

using namespace servobus;
using namespace zlac8015d_bench;
using switches = sim::zlac8015d_options;

TEST_CASE(
    "B31: after a stop input that releases the shafts the running bits are set while the wheels roll, or "
    "they are 0 without power") {
    for (const auto interpretation :
         {switches::running::turns, switches::running::driven, switches::running::enabled}) {
        CAPTURE(static_cast<int>(interpretation));
        bench b{{.bit = interpretation}};
        b.set(map::input_stop, 1);
        b.set(map::quick_stop_option_code, 7); // immediate
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, 100}) == 0);
        b.run(1500);
        CHECK(b.status().left.is_running);
        CHECK(b.status().right.is_running);
        b.drive.set_input(true, false);
        b.run(5);
        CHECK(b.get(map::left_actual_speed) > 900); // 0.1 r/min
        CHECK(b.get(map::right_actual_speed) > 900);
        const bool is_set = interpretation == switches::running::turns;
        CHECK(b.status().left.is_running == is_set);
        CHECK(b.status().right.is_running == is_set);
        b.run(5000);
        CHECK(b.get(map::left_actual_speed) == 0);
        CHECK_FALSE(b.status().is_running());
    }
}

TEST_CASE("B31: during a quick stop that brakes the wheels the running bits are set if they say that the "
          "wheels are driven") {
    bench b{{.bit = switches::running::driven}};
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, 100}) == 0);
    b.run(1500);
    b.command(control_code::quick_stop);
    b.run(2);
    CHECK(b.status().left.is_running);
    b.run(500);
    CHECK_FALSE(b.status().is_running());
}

TEST_CASE("B30: a motor without power shows a released shaft, or an emergency stop; locked by 2007h it shows "
          "that") {
    for (const auto shown : {switches::idle::released, switches::idle::emergency}) {
        const auto expected =
            shown == switches::idle::released ? shaft_state::released : shaft_state::emergency_stop;
        bench b{{.idle_shaft = shown}};
        CHECK(b.status().left.shaft == expected);
        CHECK(b.status().right.shaft == expected);
        b.begin(operating_mode::velocity);
        CHECK(b.status().left.shaft == shaft_state::locked);
        b.command(control_code::stop);
        b.run(1000);
        CHECK(b.status().left.shaft == expected);
        b.set(map::shaft_at_power_on, 1);
        b.command(control_code::fault_reset);
        CHECK(b.write(0x2010, {1}) == 0);
        b.drive.power_cycle();
        CHECK(b.status().left.shaft == shaft_state::locked);
    }
}

TEST_CASE("B31: the speed registers show the speed of a move too, or 0 in the position modes") {
    for (const auto mode :
         {operating_mode::relative_position, operating_mode::absolute_position, operating_mode::velocity}) {
        bench b{{.shows_speed_of_moves = false}};
        b.set(map::position_synchronisation, 1);
        b.begin(mode);
        CHECK(b.write(0x2088, {20, 20}) == 0);
        CHECK(b.write(0x208A, {0, 20000, 0, 20000}) == 0);
        if (mode != operating_mode::velocity) b.command(control_code::start_both);
        b.run(700);
        CHECK(b.drive.left().speed != 0);
        CHECK((b.get(map::left_actual_speed) != 0) == (mode == operating_mode::velocity));
        CHECK((b.get(map::right_actual_speed) != 0) == (mode == operating_mode::velocity));
    }
}

TEST_CASE("B35: 08h before a mode is ignored, or enables a drive that obeys the mode which is set then") {
    for (const bool enables : {false, true}) {
        bench b{{.enables_without_mode = enables}};
        b.command(control_code::enable);
        CHECK(b.drive.enabled() == enables);
        b.set(map::mode_of_operation, static_cast<std::uint16_t>(operating_mode::velocity));
        CHECK(b.write(0x2088, {20, 20}) == 0);
        b.run(1000);
        CHECK((b.drive.left().speed != 0) == enables);
    }
}

TEST_CASE("B21: a new 2022h scales the speeds from the next power-on if it was saved, or immediately") {
    for (const bool is_immediate : {false, true}) {
        for (const bool is_saved : {false, true}) {
            bench b{{.rescales_immediately = is_immediate}};
            const auto speed = [&] {
                b.begin(operating_mode::velocity);
                CHECK(b.write(0x2088, {20, 20}) == 0);
                b.run(1000);
                const std::int64_t got = b.drive.left().speed;
                b.command(control_code::stop);
                b.run_until_still();
                return got;
            };
            b.set(map::speed_resolution, 10);
            if (is_saved) CHECK(b.write(0x2010, {1}) == 0);
            CHECK(b.get(map::speed_resolution) == 10);
            CHECK(speed() == (is_immediate ? 2'000'000 : 20'000'000));
            b.drive.power_cycle();
            CHECK(b.get(map::speed_resolution) == (is_saved ? 10 : 1));
            CHECK(speed() == (is_saved ? 2'000'000 : 20'000'000));
            // The factory's value counts from the next power-on too.
            CHECK(b.write(0x2009, {1}) == 0);
            CHECK(b.get(map::speed_resolution) == 1);
            CHECK(speed() == (is_saved && !is_immediate ? 2'000'000 : 20'000'000));
            b.drive.power_cycle();
            CHECK(speed() == 20'000'000);
        }
    }
}

TEST_CASE("B14: 2012h to 2014h take the printed codes, or any word; 2011h keeps its range") {
    for (const bool checks : {true, false}) {
        bench b{{.checks_option_codes = checks}};
        for (const std::uint16_t address : std::initializer_list<std::uint16_t>{0x2012, 0x2013, 0x2014}) {
            CHECK((b.write(address, {500}) == 0) == !checks);
            CHECK(b.write(address, {1}) == 0);
        }
        CHECK(b.write(0x2011, {500}) == 3);
    }
}

TEST_CASE("B33: if a fault switches only its wheel off, a start moves the other wheel alone") {
    for (const bool is_left : {true, false}) {
        CAPTURE(is_left);
        bench b{{.by_fault = switches::switched_off::its_wheel}};
        b.set(map::position_synchronisation, 1);
        b.begin(operating_mode::relative_position);
        b.drive.raise(is_left ? fault::overcurrent : fault::none, is_left ? fault::none : fault::overcurrent);
        CHECK(b.drive.enabled());
        CHECK((b.status().left.shaft == shaft_state::alarm) == is_left);
        CHECK((b.status().right.shaft == shaft_state::alarm) == !is_left);
        CHECK(b.write(0x208A, {0, 1000, 0, 1000}) == 0);
        b.command(control_code::start_both);
        b.run(2000);
        CHECK(b.get(map::left_actual_position) == (is_left ? 0 : 1000));
        CHECK(b.get(map::right_actual_position) == (is_left ? 1000 : 0));
        b.set(map::position_synchronisation, 0);
        b.command(is_left ? control_code::start_left : control_code::start_right);
        b.run(2000);
        CHECK(b.get(map::left_actual_position) == (is_left ? 0 : 1000));
        CHECK(b.get(map::right_actual_position) == (is_left ? 1000 : 0));
        CHECK(b.drive.starts() == 1);
    }
}

TEST_CASE("B33: if a fault switches only its wheel off, faults of both wheels disable the drive") {
    for (const bool is_left_first : {true, false}) {
        CAPTURE(is_left_first);
        bench b{{.by_fault = switches::switched_off::its_wheel}};
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, 100}) == 0);
        b.run(1500);
        b.drive.raise(is_left_first ? fault::hall : fault::none, is_left_first ? fault::none : fault::hall);
        b.run(500);
        CHECK(b.drive.enabled());
        const int left = is_left_first ? 0 : 1000; // 0.1 r/min
        CHECK(b.get(map::left_actual_speed) == left);
        CHECK(b.get(map::right_actual_speed) == 1000 - left);
        b.drive.raise(fault::hall, fault::hall);
        CHECK_FALSE(b.drive.enabled());
        CHECK(b.status().left.shaft == shaft_state::alarm);
        CHECK(b.status().right.shaft == shaft_state::alarm);
        b.command(control_code::enable);
        CHECK_FALSE(b.drive.enabled());
        b.drive.end_faults();
        b.command(control_code::fault_reset);
        CHECK(b.status().left.shaft == shaft_state::released); // and not enabled by itself
        CHECK(b.status().right.shaft == shaft_state::released);
    }
}

} // namespace sim_zlac8015d_interpretations_tests
