// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stops of the simulated C630S: servo off, the brake, limit switches, an emergency stop, alarms. How alarms
// are reset and recorded.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_stops_tests {

using namespace servobus;
using namespace c630s_bench;

// Stopping

TEST_CASE("P02-05: at servo off the motor coasts or stops at zero speed") {
    for (const int how : {0, 1}) {
        bench b;
        b.assign({});
        b.set(map::mode_of_operation, map::control_mode::speed);
        b.set(map::target_speed, 1000);
        b.set(map::stop_at_servo_off, how);
        b.restart();
        b.enable();
        b.run(1000);
        b.virtual_levels(0);
        const std::uint32_t ms = b.run_until_still();
        CHECK((how == 0 ? ms > 300 : ms < 60));
        CHECK_FALSE(b.drive.enabled());
        CHECK(b.drive.current_state() == (how == 0 ? sim::c630s::state::off : b.drive.current_state()));
    }
}

TEST_CASE("a brake delays the first command and the switching off of the power") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::do1_function, out::brake);
    b.restart();
    b.enable();
    CHECK(b.drive.output(1));
    b.run(240);
    CHECK(b.drive.stands_still());
    b.run(100);
    CHECK(b.get(map::actual_speed) == 200);
    b.set(map::target_speed, 0);
    b.run(200);
    b.virtual_levels(0);
    b.run(2);
    CHECK_FALSE(b.drive.output(1));
    CHECK(b.drive.current_state() == sim::c630s::state::stopping);
    b.run(150);
    CHECK(b.drive.current_state() == sim::c630s::state::off);
}

TEST_CASE("P02-07 sets how limit switches stop the motor") {
    for (const int how : {0, 1, 2}) {
        bench b;
        b.assign({in::positive_overtravel});
        b.set(map::mode_of_operation, map::control_mode::speed);
        b.set(map::stop_at_overtravel, how);
        b.restart();
        b.enable();
        b.run(200);
        b.virtual_levels(3);
        b.run(100);
        CHECK(b.drive.has_alarm(0x950));
        if (how != 0) CHECK(b.drive.stands_still());
        CHECK(b.drive.enabled() == (how == 1));
        b.run_until_still();
        if (how != 1) { // S-ON is needed again
            b.virtual_levels(2);
            b.run(2);
            b.virtual_levels(3);
            b.run(100);
            CHECK(b.drive.enabled());
        }
        CHECK(b.drive.stands_still()); // forward motion is blocked
        b.set(map::target_speed, -200);
        b.run(200);
        CHECK(b.get(map::actual_speed) == -200);
        b.virtual_levels(1);
        b.run(2);
        CHECK_FALSE(b.drive.has_warning());
        b.set(map::target_speed, 200);
        b.run(400);
        CHECK(b.get(map::actual_speed) == 200);
    }
}

TEST_CASE("a limit switch ends a move; a move towards it does not begin") {
    bench b;
    b.begin_segments(map::segment_mode::single, {in::positive_overtravel});
    b.start();
    b.run(100);
    b.virtual_levels(5);
    b.run(100);
    CHECK(b.drive.stands_still());
    const std::int64_t there = b.drive.position();
    b.start(4);
    b.run(500);
    CHECK(b.drive.position() == there);
}

TEST_CASE("an emergency stop ends at zero speed, locked, with Er.900; afterwards the speed command "
          "continues") {
    for (const bool by_bus : {false, true}) {
        bench b;
        b.assign({in::emergency_stop});
        b.set(map::mode_of_operation, map::control_mode::speed);
        b.set(map::target_speed, 1000);
        b.restart();
        b.enable();
        b.run(1000);
        if (by_bus) {
            b.set(map::emergency_stop, map::action::execute);
        } else {
            b.virtual_levels(3);
        }
        b.run(60);
        CHECK(b.drive.stands_still());
        CHECK(b.drive.enabled());
        CHECK(b.drive.has_alarm(0x900));
        CHECK_FALSE(b.drive.has_fault());
        b.set(map::emergency_stop, map::action::none);
        b.virtual_levels(1);
        b.run(1000);
        CHECK(b.get(map::actual_speed) == 1000);
        CHECK(b.drive.has_alarm(0x900)); // until it is reset
    }
}

// Alarms

TEST_CASE("a fault disables the drive; it can be reset only with S-ON off") {
    bench b;
    b.assign({in::alarm_reset});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    b.enable();
    b.run(100);
    b.drive.raise(0x620);
    CHECK_FALSE(b.drive.enabled());
    CHECK_FALSE(b.drive.is_active(out::servo_ready));
    CHECK(b.drive.is_active(out::fault));
    b.run_until_still();
    b.set(map::alarm_reset, 1); // S-ON is still set
    CHECK(b.drive.has_fault());
    b.virtual_levels(3);
    b.run(2);
    CHECK(b.drive.has_fault());
    b.virtual_levels(0);
    b.run(2);
    b.virtual_levels(2); // the edge of FunIN.2
    b.run(2);
    CHECK_FALSE(b.drive.has_fault());
    b.enable();
}

TEST_CASE("every alarm is reset as its class defines") {
    for (const map::alarm& a : map::alarms) {
        CAPTURE(a.code);
        bench b;
        b.assign({in::alarm_reset});
        b.restart();
        b.enable();
        b.drive.raise(a.code);
        b.run(2);
        const bool is_fault = a.kind == map::alarm_class::fault;
        const bool is_momentary = a.code == 0x950 || a.code == 0x952; // ends with its switch
        CHECK(b.drive.has_alarm(a.code) == !is_momentary);
        CHECK(b.drive.has_fault() == is_fault);
        CHECK(b.drive.enabled() == !is_fault);
        if (!is_momentary) CHECK(b.get(map::recorded_alarm) == a.code);
        b.virtual_levels(3);
        b.run(2);
        CHECK(b.drive.has_alarm(a.code) == is_fault);
        b.virtual_levels(0);
        b.run(2);
        const bool is_encoder = a.code == 0x731 || a.code == 0x733 || a.code == 0x735;
        b.set(map::alarm_reset, 1);
        CHECK(b.drive.has_alarm(a.code) == (!a.is_resettable || is_encoder));
        b.restart();
        CHECK(b.drive.has_alarm(a.code) == is_encoder);
    }
}

TEST_CASE("an alarm returns while its cause lasts") {
    bench b;
    b.drive.raise(0x210, true);
    b.restart();
    CHECK(b.drive.has_alarm(0x210));
    b.drive.end_causes();
    b.restart();
    CHECK_FALSE(b.drive.has_fault());
    b.drive.set_bus_voltage(1500);
    b.run(2);
    CHECK(b.drive.has_alarm(0x410));
    b.set(map::alarm_reset, 1);
    CHECK(b.drive.has_alarm(0x410));
    b.drive.set_bus_voltage(3100);
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_fault());
    CHECK(b.get(map::bus_voltage) == 3100);
}

TEST_CASE("the last ten alarms are recorded with their measurements") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    b.run(5000);
    b.enable();
    b.run(1000);
    b.drive.raise(0x620);
    CHECK(b.get(map::recorded_alarm) == 0x620);
    CHECK(b.get(map::recorded_speed) == 200);
    CHECK(b.get(map::recorded_time) == 6);
    CHECK(b.get(map::recorded_bus_voltage) == 3100);
    CHECK(b.get(map::recorded_inputs).bits == 0xFF);
    b.virtual_levels(0);
    b.run_until_still();
    b.set(map::alarm_reset, 1);
    CHECK(b.get(map::recorded_alarm) == 0); // record 0 is the present alarm
    b.set(map::selected_fault_record, 1);
    CHECK(b.get(map::recorded_alarm) == 0x620);
    for (int i = 0; i < 12; ++i) {
        b.drive.raise(i % 2 == 0 ? 0x500 : 0x510);
        b.set(map::alarm_reset, 1);
    }
    b.restart(); // the records are kept without power
    b.drive.raise(0x400);
    for (int i = 0; i < 10; ++i) {
        b.set(map::selected_fault_record, i);
        CHECK(b.get(map::recorded_alarm) == (i == 0 ? 0x400 : i % 2 == 1 ? 0x510 : 0x500));
    }
    b.set(map::alarm_reset, 1);
    b.set(map::initialise_parameters, map::initialisation::clear_fault_records);
    for (int i = 0; i < 10; ++i) {
        b.set(map::selected_fault_record, i);
        CHECK(b.get(map::recorded_alarm) == 0);
    }
}

TEST_CASE("resetting faults of the absolute encoder needs P0D-20, then P0D-01") {
    bench b;
    b.set(map::encoder_type, map::encoder_kind::absolute);
    b.assign({});
    b.restart();
    b.enable();
    b.virtual_levels(0);
    b.run(2);
    b.drive.raise(0x733);
    b.set(map::alarm_reset, 1);
    CHECK(b.drive.has_alarm(0x733));
    b.set(map::reset_absolute_encoder, 2);
    CHECK(b.drive.has_alarm(0x733));
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_fault());
    CHECK(b.get(map::reset_absolute_encoder) == map::encoder_reset::none);
    b.set(map::multiturn_overflow_masking, 1);
    b.drive.raise(0x735);
    CHECK_FALSE(b.drive.has_fault());
}

// Options and thresholds

TEST_CASE("a brake on a virtual output also delays commands, unless an option is set") {
    for (const bool delays : {true, false}) {
        bench b{{.virtual_brake_delays = delays}};
        b.set(map::virtual_output_functions[8], out::brake);
        b.set(map::virtual_outputs_enable, 1);
        b.begin_segments(map::segment_mode::single);
        CHECK(b.get(map::virtual_output_levels).bits == 0x100);
        b.start();
        b.run(1000);
        CHECK(b.drive.starts() == (delays ? 0 : 1));
        b.start();
        b.run_until_still();
        CHECK(b.drive.starts() == (delays ? 1 : 2));
    }
}

TEST_CASE("P0D-01 is accepted only by a stopped drive, unless an option is set") {
    for (const bool may : {false, true}) {
        bench b{{.resets_while_enabled = may}};
        b.assign({});
        b.restart();
        b.enable();
        b.drive.raise(0x909);
        CHECK(b.put(map::alarm_reset, 1) == (may ? 0 : 4));
        CHECK(b.drive.has_warning() == !may);
        CHECK(b.drive.enabled());
    }
}

TEST_CASE("overspeed and a too high voltage at an analogue input cause faults") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::overspeed_threshold, 150);
    b.restart();
    b.enable();
    b.run(100);
    CHECK(b.drive.has_alarm(0x500));
    CHECK_FALSE(b.drive.enabled());
    bench c;
    c.drive.set_analogue(11'600, 0);
    c.run(2);
    CHECK(c.drive.has_alarm(0x834));
}

} // namespace sim_c630s_stops_tests
