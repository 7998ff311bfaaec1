// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The inputs and outputs of the simulated C630S: real and virtual ones, their functions, logics and edges,
// and the bus variables that show them.
#include <doctest/doctest.h>

#include <initializer_list>

#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>

namespace sim_c630s_inputs_tests {

using namespace servobus;
using namespace c630s_bench;

TEST_CASE("S-ON on a virtual input takes effect only after a power cycle") {
    bench b;
    b.assign({});
    b.virtual_levels(1);
    b.run(10);
    CHECK_FALSE(b.drive.enabled());
    b.restart();
    b.run(10);
    CHECK_FALSE(b.drive.enabled()); // P31-00 is 0
    b.enable();
    CHECK(b.drive.enables() == 1);
    b.virtual_levels(0);
    b.run(2);
    CHECK_FALSE(b.drive.enabled());
}

TEST_CASE("S-ON on a real and a virtual input causes Er.130") {
    bench b;
    b.set(map::virtual_input_functions[0], in::servo_on);
    b.set(map::virtual_inputs_enable, 1);
    b.run(5);
    CHECK_FALSE(b.drive.has_fault()); // not in effect yet
    b.restart();
    CHECK(b.drive.has_alarm(0x130));
    b.virtual_levels(1);
    b.run(5);
    CHECK_FALSE(b.drive.enabled());
    b.virtual_levels(0);
    b.set(map::alarm_reset, 1);
    CHECK(b.drive.has_alarm(0x130)); // its cause is still there
    b.set(map::di1_function, 0);
    b.restart();
    CHECK_FALSE(b.drive.has_fault());
}

TEST_CASE("any function on two terminals causes Er.130 as soon as it takes effect") {
    bench b;
    b.set(map::virtual_input_functions[3], in::homing_start); // DI8 has it by default
    CHECK_FALSE(b.drive.has_fault());
    b.set(map::virtual_inputs_enable, 1);
    CHECK(b.drive.has_alarm(0x130));
    b.set(map::di8_function, 0);
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_fault());
}

TEST_CASE("P0C-10 sets the virtual levels at power-on") {
    bench b;
    b.assign({});
    b.set(map::virtual_inputs_at_power_on, 1);
    b.restart();
    b.run(5);
    CHECK(b.drive.enabled());
    CHECK(b.get(map::virtual_input_levels).bits == 0);
    b.virtual_levels(0);
    b.run(5);
    CHECK_FALSE(b.drive.enabled());
}

TEST_CASE("real inputs have the functions of section 6.4.1 and their logics") {
    bench b;
    b.drive.set_input(1, true);
    b.run(3);
    CHECK(b.drive.enabled()); // DI1 is S-ON, active low
    CHECK(b.get(map::input_state).bits == 0xFE);
    CHECK(b.get(map::input_conduction).bits == 1);
    b.drive.set_input(1, false);
    b.run(3);
    CHECK_FALSE(b.drive.enabled());
    b.drive.set_input(2, true);
    CHECK(b.drive.is_active(in::positive_overtravel));
    b.set(map::di2_logic, map::input_logic::high_level);
    b.run(2);
    CHECK_FALSE(b.drive.is_active(in::positive_overtravel));
    b.set(map::di7_logic, map::input_logic::rising_edge); // a home switch uses levels only
    b.run(2);
    CHECK(b.drive.is_active(in::home_switch));
    // P03-03 = 1 enables the drive at power-on
    b.set(map::di1_logic, map::input_logic::high_level);
    b.run(3);
    CHECK_FALSE(b.drive.enabled());
    b.drive.set_input(2, false);
    b.set(map::di2_logic, map::input_logic::low_level);
    b.restart();
    b.run(3);
    CHECK(b.drive.enabled());
}

TEST_CASE("P03-00 bit 0 enables the drive at power-on") {
    bench b;
    b.set(map::power_on_functions_1_to_16, 1);
    CHECK(b.drive.has_alarm(0x941));
    b.run(3);
    CHECK_FALSE(b.drive.enabled());
    b.restart();
    b.run(3);
    CHECK(b.drive.enabled());
}

TEST_CASE("P0D-17 forces inputs and outputs") {
    bench b;
    b.set(map::terminal_forcing, map::forcing::both);
    b.run(3);
    CHECK_FALSE(b.drive.enabled()); // P0D-18 is all high
    CHECK(b.get(map::output_state).bits == 0);
    b.set(map::forced_inputs, 0x1FE);
    b.set(map::forced_outputs, 0x12);
    b.run(3);
    CHECK(b.drive.enabled());
    CHECK(b.get(map::output_state).bits == 0x12);
    CHECK(b.drive.output(2));
    b.set(map::terminal_forcing, map::forcing::none);
    b.run(3);
    CHECK_FALSE(b.drive.enabled());
    CHECK(b.drive.output(1)); // S-RDY
}

TEST_CASE("virtual outputs show their functions, or a default level if they have none") {
    bench b;
    b.set(map::virtual_output_functions[0], out::servo_ready);
    b.set(map::virtual_output_functions[1], out::fault);
    b.set(map::virtual_output_logics[1], 1);
    b.set(map::virtual_output_defaults, 0x8002);
    CHECK(b.get(map::virtual_output_levels).bits == 0);
    b.set(map::virtual_outputs_enable, 1);
    CHECK(b.get(map::virtual_output_levels).bits == 0x8003);
    b.drive.raise(0x620);
    CHECK(b.get(map::virtual_output_levels).bits == 0x8000);
    CHECK_FALSE(b.drive.output(1));
    CHECK(b.drive.output(4)); // ALM
}

TEST_CASE("bus variables show state, functions and conduction") {
    bench b;
    b.assign({});
    b.restart();
    CHECK(b.get(map::servo_status) == 1);
    CHECK(b.get(map::active_functions_1_to_16).has(out::servo_ready));
    CHECK(b.get(map::active_functions_1_to_16).has(out::zero_speed));
    b.enable();
    CHECK(b.get(map::servo_status) == 2);
    CHECK(b.get(map::active_functions_1_to_16).has(out::positioning_completed));
    b.set(map::homing_control, map::homing::set_home);
    b.run(1);
    CHECK(b.get(map::active_functions_1_to_16).has(out::home_attained));
    b.drive.raise(0x500);
    CHECK(b.get(map::servo_status) == 3);
}

TEST_CASE("the logic of an input defines on which edges it acts") {
    for (const auto logic : {map::input_logic::rising_edge, map::input_logic::falling_edge,
                             map::input_logic::both_edges, map::input_logic::low_level}) {
        bench b;
        b.set(map::position_command_source, map::position_source::step);
        b.set(map::position_step, 5000);
        b.set(map::di2_function, in::step_enable);
        b.set(map::di2_logic, logic);
        b.drive.set_input(1, true);
        b.run(3);
        CHECK(b.drive.enabled());
        b.drive.set_input(2, true); // the level falls
        b.run(400);
        const bool on_falling = logic != map::input_logic::rising_edge;
        CHECK(b.drive.starts() == (on_falling ? 1 : 0));
        b.drive.set_input(2, false);
        b.run(400);
        const bool on_rising =
            logic == map::input_logic::rising_edge || logic == map::input_logic::both_edges;
        CHECK(b.drive.starts() == (on_falling ? 1u : 0u) + (on_rising ? 1u : 0u));
        CHECK(b.drive.position() == turn / 2 * b.drive.starts());
    }
}

TEST_CASE("edges between two ticks are not lost") {
    bench b;
    b.assign({in::step_enable});
    b.set(map::position_command_source, map::position_source::step);
    b.restart();
    b.enable();
    b.virtual_levels(3);
    b.virtual_levels(1);
    b.run(100);
    CHECK(b.drive.starts() == 1);
}

TEST_CASE("S-ON on an edge does not enable the drive") {
    bench b;
    b.assign({});
    b.set(map::virtual_input_logics[0], 1);
    b.restart();
    b.virtual_levels(1);
    b.run(10);
    CHECK_FALSE(b.drive.enabled());
}

} // namespace sim_c630s_inputs_tests
