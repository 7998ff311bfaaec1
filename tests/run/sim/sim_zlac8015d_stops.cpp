// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The states of the simulated ZLAC8015D, and the stops of its wheels: stop and quick stop, the watchdog,
// faults, inputs, brakes.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_stops_tests {

using namespace servobus;
using namespace zlac8015d_bench;

// States

TEST_CASE("the drive is enabled only in a mode; an enable without a mode is ignored, and only the status "
          "shows it") {
    bench b;
    b.command(control_code::enable);
    CHECK(!b.drive.enabled());
    CHECK(b.status().left.shaft == shaft_state::released);
    b.begin(operating_mode::velocity);
    CHECK(b.get(map::status_word).to_word() == map::status_flags::both_locked);
    CHECK(b.drive.enables() == 1);
    b.command(control_code::enable);
    CHECK(b.drive.enables() == 1);
}

TEST_CASE("S2: an enable moves the wheels immediately if the targets are not zero") {
    bench b;
    b.mode(operating_mode::velocity);
    b.set(map::left_target_speed, 50);
    b.run(100);
    CHECK(b.drive.stands_still());
    b.command(control_code::enable);
    b.run(100);
    CHECK(!b.drive.stands_still());
}

TEST_CASE("S3: the mode changes only while both wheels are at standstill") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::right_target_speed, 20);
    b.run(50);
    b.mode(operating_mode::torque); // acknowledged and ignored
    CHECK(b.get(map::mode_of_operation) == operating_mode::velocity);
    b.set(map::right_target_speed, 0);
    b.run_until_still();
    b.mode(operating_mode::torque);
    CHECK(b.get(map::mode_of_operation) == operating_mode::torque);
    CHECK(b.drive.enabled());
    b.mode(operating_mode::undefined);
    CHECK(!b.drive.enabled());
}

TEST_CASE("a stop slows the wheels down and then releases the shafts, or releases them immediately") {
    for (const bool ramps : {true, false}) {
        bench b{{.speed_ramp = sim::zlac8015d_options::ramp::linear}};
        b.set(map::disable_option_code, ramps ? 1 : 0);
        b.begin(operating_mode::velocity);
        CHECK(b.write(0x2088, {100, -100}) == 0);
        b.run(1000);
        b.command(control_code::stop);
        CHECK(!b.drive.enabled());
        b.run(400);
        CHECK(!b.drive.stands_still());
        if (ramps) CHECK(about(b.drive.left().speed, 20 * one_r_per_min, one_r_per_min));
        const std::uint32_t rest = b.run_until_still();
        CHECK((ramps ? rest < 105 : rest > 300));
        CHECK(b.get(map::status_word).to_word() == 0);
    }
}

TEST_CASE("a quick stop follows its option, holds the shafts and lasts until the next enable") {
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
        b.command(control_code::quick_stop);
        const std::uint32_t took = b.run_until_still();
        CHECK(took >= c.shortest);
        CHECK(took <= c.longest);
        CHECK(b.get(map::status_word).to_word() == map::status_flags::both_stopped_in_emergency);
        b.run(500);
        b.set(map::left_target_speed, 10);
        b.command(control_code::start_left);
        b.run(500);
        CHECK(b.drive.stands_still());
        b.command(control_code::enable);
        b.run(100);
        CHECK(!b.drive.stands_still());
    }
}

TEST_CASE("a quick stop of a disabled drive changes nothing; a stop ends a quick stop") {
    bench b;
    b.command(control_code::quick_stop);
    CHECK(b.get(map::status_word).to_word() == 0);
    b.begin(operating_mode::velocity);
    b.command(control_code::quick_stop);
    CHECK(b.status().left.shaft == shaft_state::emergency_stop);
    b.command(control_code::stop);
    b.run(2);
    CHECK(b.get(map::status_word).to_word() == 0);
}

// Watchdog

TEST_CASE("G19: both wheels stop if no request arrives for longer than 2000h, and not earlier") {
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
    CHECK(map::status_flags::from_word(b.drive.peek(0x20A2)).left.shaft == shaft_state::emergency_stop);
}

TEST_CASE("S3: after a watchdog stop the targets are still set, and any request lets the wheels go on") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.silent(3000);
    CHECK(b.drive.stands_still());
    CHECK(b.get(map::bus_voltage) == 2400); // only a read
    CHECK(!b.drive.in_watchdog_stop());
    b.run(600);
    CHECK(b.get(map::left_actual_speed) == 1000);
    b.silent(3000);
    CHECK(b.write(0x2088, {0, 0}) == 0); // the right first frame
    const std::int64_t here = b.drive.left().position;
    b.run(1000);
    CHECK(b.drive.left().position == here);
}

TEST_CASE("S3: a position move also continues after a watchdog stop") {
    bench b;
    b.begin(operating_mode::relative_position);
    b.set(map::left_target_position, 20'480);
    b.command(control_code::start_left);
    b.run(500);
    b.silent(5000);
    CHECK(b.drive.left().position < 20'480);
    b.run_until_still();
    CHECK(b.drive.left().position == 20'480);
    CHECK(b.drive.starts() == 1);
}

TEST_CASE("S3: by the manual's other interpretation the drive stays in quick stop after a watchdog stop") {
    bench b{{.resumes_after_watchdog = false}};
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.silent(3000);
    b.run(1000);
    CHECK(b.drive.stands_still());
    CHECK(b.drive.in_watchdog_stop());
    CHECK(b.get(map::status_word).to_word() == map::status_flags::both_stopped_in_emergency);
    b.command(control_code::enable);
    b.run(1000);
    CHECK(!b.drive.in_watchdog_stop());
    CHECK(b.get(map::left_actual_speed) == 1000);
}

TEST_CASE(
    "a watchdog time of 0 switches the watchdog off, or by the other interpretation an enabled drive stops "
    "immediately") {
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

TEST_CASE("S3: a fault of one wheel stops both, and is cleared only when its cause is gone") {
    bench b;
    b.begin(operating_mode::velocity);
    CHECK(b.write(0x2088, {100, 100}) == 0);
    b.run(1000);
    b.drive.raise(fault::overcurrent, fault::none);
    CHECK(!b.drive.enabled());
    CHECK(b.status().left.shaft == shaft_state::alarm);
    CHECK(b.get(map::left_faults).has(fault::overcurrent));
    b.run_until_still();
    b.command(control_code::enable);
    CHECK(!b.drive.enabled());
    b.command(control_code::fault_reset);
    CHECK(b.get(map::left_faults).any());
    b.drive.end_faults();
    CHECK(b.get(map::left_faults).any());
    b.command(control_code::enable);
    CHECK(!b.drive.enabled());
    b.command(control_code::fault_reset);
    CHECK(!b.get(map::left_faults).any());
    CHECK(!b.drive.enabled());
    b.command(control_code::enable);
    CHECK(b.drive.enabled());
}

TEST_CASE("with 201Fh = 1 the wheels brake after a fault, with 0 they coast") {
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

TEST_CASE("the stop input causes a quick stop as 2011h and 2021h define, by its function and polarity") {
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
                // the wheel coasts without power
                if (option == 7) CHECK((release != 0 ? took > 1000 : took < 3));
                CHECK(b.status().left.shaft == shaft_state::emergency_stop);
                b.command(control_code::enable);
                CHECK(!b.drive.enabled());
                b.drive.set_input(inverted, inverted);
                b.run(1000);
                CHECK(b.drive.stands_still());
                b.command(control_code::enable);
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

TEST_CASE("a closed brake blocks its wheel; a wheel that is driven against it is overloaded after its "
          "overload time") {
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

TEST_CASE("the Hall state goes through its six values while the wheel turns") {
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

} // namespace sim_zlac8015d_stops_tests
