// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rare cases of the simulated C630S: levels and forced terminals, alarms by age and cause, and access to
// parameters, terminals and alarms that do not exist.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_terminals_tests {

using namespace servobus;
using namespace c630s_bench;

// Terminals

TEST_CASE("P0D-17 may force only the inputs, or only the outputs") {
    for (const auto how : {map::forcing::inputs_only, map::forcing::outputs_only}) {
        const bool is_input = how == map::forcing::inputs_only;
        bench b;
        b.set(map::forced_inputs, 0x1FE); // DI1, servo-on, is low
        b.set(map::forced_outputs, 0x12);
        b.set(map::terminal_forcing, how);
        b.run(3);
        CHECK(b.drive.enabled() == is_input);
        CHECK(b.get(map::input_state).bits == (is_input ? 0xFE : 0xFF));
        CHECK(b.drive.output(5) == !is_input);
        CHECK(b.drive.output(1) == is_input); // S-RDY
    }
}

TEST_CASE("a home switch and FunIN.33 use levels only: a falling edge means low, a rising one high") {
    for (const auto f : {in::home_switch, in::interrupt_inhibit}) {
        for (const auto how : {map::input_logic::rising_edge, map::input_logic::falling_edge}) {
            bench b;
            b.set(map::di7_function, in::none);
            b.set(map::di8_function, f);
            b.set(map::di8_logic, how);
            b.run(2);
            const bool is_high = how == map::input_logic::rising_edge;
            CHECK(b.drive.is_active(f) == is_high); // an open input is high
            b.drive.set_input(8, true);
            b.run(2);
            CHECK(b.drive.is_active(f) == !is_high);
        }
    }
}

TEST_CASE("virtual outputs without a brake among them delay no command") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::virtual_output_functions[0], out::servo_ready);
    b.set(map::virtual_outputs_enable, 1);
    b.set(map::brake_on_to_command_delay, 500);
    b.restart();
    b.enable();
    b.run(100);
    CHECK(b.get(map::actual_speed) == 200);
}

TEST_CASE("servo off at zero speed takes effect immediately at standstill without a brake") {
    bench b;
    b.assign({});
    b.set(map::stop_at_servo_off, map::stop_mode::zero_speed);
    b.restart();
    b.enable();
    b.run(10);
    b.virtual_levels(0);
    b.run(1);
    CHECK(b.drive.current_state() == sim::c630s::state::off);
}

// Alarms

TEST_CASE("Er.400 occurs above 420 V, and Er.834 beyond 11.5 V at an analogue input") {
    bench b;
    b.drive.set_bus_voltage(4200);
    b.run(2);
    CHECK_FALSE(b.drive.has_fault());
    b.drive.set_bus_voltage(4201);
    b.run(2);
    CHECK(b.drive.has_alarm(0x400));
    CHECK(b.drive.alarm() == 0x400);
    b.drive.set_bus_voltage(3100);
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_fault());
    b.drive.set_analogue(0, -11'500);
    b.run(2);
    CHECK_FALSE(b.drive.has_fault());
    b.drive.set_analogue(0, -11'501);
    b.run(2);
    CHECK(b.drive.has_alarm(0x834));
}

TEST_CASE("the present alarm is the newest fault, or else the newest warning; the records keep their order") {
    bench b;
    CHECK(b.drive.alarm() == 0);
    b.drive.raise(0x941); // a warning
    CHECK(b.drive.alarm() == 0x941);
    b.drive.raise(0x620);
    b.drive.raise(0x900); // a newer warning
    CHECK(b.drive.alarm() == 0x620);
    const std::uint16_t wanted[] = {0x620, 0x900, 0x941, 0};
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        b.set(map::selected_fault_record, i);
        CHECK(b.get(map::recorded_alarm) == wanted[i]);
    }
}

TEST_CASE("a code that is not in chapter 8 sets no alarm, whether its cause lasts or not") {
    bench b;
    b.drive.raise(0x999);
    b.drive.raise(0x999, true);
    b.run(10);
    CHECK_FALSE(b.drive.has_alarm(0x999));
    CHECK_FALSE(b.drive.has_fault());
    CHECK_FALSE(b.drive.has_warning());
    CHECK(b.drive.alarm() == 0);
    CHECK(b.get(map::recorded_alarm) == 0);
}

TEST_CASE("ending an alarm that does not exist has no effect, and there are ten records") {
    sim::detail::c630s_alarms alarms;
    for (std::uint16_t i = 0; i < 12; ++i) {
        REQUIRE(alarms.set({.code = 0x500, .time = i}));
        alarms.end(0x999);
        REQUIRE(alarms.is_present(0x500));
        alarms.end(0x500);
        REQUIRE_FALSE(alarms.is_present(0x500));
    }
    CHECK(alarms.record(1).time == 11);
    CHECK(alarms.record(10).time == 2);
    CHECK(alarms.record(11).code == 0);
}

TEST_CASE("with its option set, P0D-01 may be written while the motor is enabled, and no other register for "
          "the stopped drive") {
    bench b{{.resets_while_enabled = true}};
    b.assign({});
    b.restart();
    b.enable();
    b.drive.raise(0x942);
    CHECK(b.put(map::mode_of_operation, 0) == 4);
    CHECK(b.put(map::alarm_reset, 1) == 0);
    CHECK_FALSE(b.drive.has_alarm(0x942));
}

// Access by tests

TEST_CASE("missing terminals, functions and parameters are 0 or inactive, and setting them has no effect") {
    bench b;
    for (const unsigned number : {0u, 9u, 33u}) {
        b.drive.set_input(number, true);
        CHECK(b.get(map::input_state).bits == 0xFF);
    }
    for (const unsigned number : {0u, 7u, 33u}) CHECK_FALSE(b.drive.output(number));
    REQUIRE(b.drive.output(1));
    CHECK_FALSE(b.drive.is_active(static_cast<out>(0)));
    CHECK_FALSE(b.drive.is_active(static_cast<out>(33)));
    CHECK_FALSE(b.drive.is_active(static_cast<in>(64)));
    for (const std::uint16_t address : {u16{0x0063}, u16{0x3263}, u16{0xFFFF}}) {
        CHECK(b.drive.peek(address) == 0);
        CHECK(b.drive.stored(address) == 0);
        CHECK(b.drive.in_force(address) == 0);
    }
    CHECK(b.drive.in_force(map::target_speed.address) == 200);
}

TEST_CASE("the last 64 writes of parameters are logged, and no older one") {
    bench b;
    CHECK(b.drive.last_write().ordinal == 0);
    for (int i = 1; i <= 70; ++i) b.set(map::target_speed, i);
    CHECK(b.drive.writes() == 70);
    CHECK(b.drive.last_write().value == 70);
    CHECK(b.drive.last_write(63).value == 7);
    CHECK(b.drive.last_write(63).address == map::target_speed.address);
    CHECK(b.drive.last_write(64).ordinal == 0);
    CHECK(b.drive.last_write(64).address == 0);
}

TEST_CASE(
    "C38: 4 is an invalid source of the auxiliary speed; 3 is taken, as an ancestor of the drive takes it") {
    bench b;
    for (int source = 0; source <= 6; ++source) {
        CAPTURE(source);
        const bool is_one = source <= 3 || source == 5;
        CHECK(b.put(map::auxiliary_speed_source, source) == (is_one ? 0 : 3));
    }
}

TEST_CASE("P0B-27 shows the temperature that a test sets") {
    bench b;
    CHECK(b.get(map::module_temperature) == 35);
    b.drive.set_module_temperature(-20);
    CHECK(b.get(map::module_temperature) == -20);
}

} // namespace sim_c630s_terminals_tests
