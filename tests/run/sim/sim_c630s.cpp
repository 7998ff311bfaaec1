// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated C630S: that it behaves as documented, so that tests of programs may lean on it.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>
#include <tests/support/simulated_c630s.hpp>

using namespace servobus;
using namespace c630s_bench;

// Parameters

TEST_CASE("a new drive has all 463 parameters at their defaults") {
    bench b;
    CHECK(map::catalogue.entries.size() == 463);
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        std::array<std::uint16_t, 2> words{};
        REQUIRE(b.drive.read(e.address, std::span<std::uint16_t>{words}.first(e.words())) == 0);
        if (e.rights == access::ro || e.initial == no_default) continue;
        const u32 bits = e.words() == 2 ? join_words(words[0], words[1], word_order::low_first) : words[0];
        CHECK(e.number(bits) == e.initial);
    }
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 57600);
    CHECK(b.drive.eeprom_writes() == 0);
    CHECK_FALSE(b.drive.has_fault());
    CHECK_FALSE(b.drive.enabled());
}

TEST_CASE("an address that does not exist is exception 2, alone and inside a block") {
    bench b;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const auto at = static_cast<std::uint16_t>(address);
        const bool exists = map::catalogue.find(at) != nullptr;
        std::array<std::uint16_t, 1> word{};
        if (b.drive.read(at, word) != (exists ? 0 : 2)) FAIL_CHECK("read of " << address);
        if (!exists && b.write(at, {0}) != 2) FAIL_CHECK("write to " << address);
    }
    std::array<std::uint16_t, 8> words{};
    CHECK(b.drive.read(0x0200, words) == 2); // P02-04 is a gap
    CHECK(b.drive.read(0x0200, std::span<std::uint16_t>{words}.first(4)) == 0);
    CHECK(b.get(map::last_bus_error) == map::bus_error::illegal_data_address);
}

TEST_CASE(
    "values at the ends of a range are taken, those beyond are exception 3, read-only rows exception 2") {
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        bench b;
        if (e.address == map::pair_word_order.address) continue; // the word order would change below
        const auto put = [&](std::int64_t v) { return b.put(e.address, v, e.words() == 2); };
        if (e.rights == access::ro) {
            CHECK(put(0) == 2);
            continue;
        }
        CHECK(put(e.limits.high) == 0);
        bench other;
        CHECK(other.put(e.address, e.limits.low, e.words() == 2) == 0);
        if (!e.limits.is_stated) continue;
        const std::int64_t top = e.words() == 2 ? 0xFFFF'FFFF : 0xFFFF;
        bench third;
        if (e.limits.high < top) CHECK(third.put(e.address, e.limits.high + 1, e.words() == 2) == 3);
        if (e.is_signed() || e.limits.low > 0)
            CHECK(third.put(e.address, e.limits.low - 1, e.words() == 2) == 3);
    }
}

TEST_CASE("holes in a range are exception 3, and a block is written as a whole or not at all") {
    bench b;
    CHECK(b.put(map::homing_control, 7) == 3);
    CHECK(b.put(map::auxiliary_speed_source, 3) == 3);
    CHECK(b.put(map::pulse_command_form, 3) == 3);
    CHECK(b.write(map::acceleration_time.address, {300, 400, 7000}) == 3); // P06-07 ends at 6000
    CHECK(b.get(map::acceleration_time) == 200);
    CHECK(b.write(map::acceleration_time.address, {300, 400, 4000}) == 0);
    CHECK(b.get(map::deceleration_time) == 400);
    CHECK(b.drive.writes() == 3);
    CHECK(b.drive.last_write(2).address == map::acceleration_time.address);
    CHECK(b.drive.last_write().value == 4000);
}

TEST_CASE("pairs are read and written in the order of P0C-26, at once") {
    bench b;
    CHECK(b.write(0x110C, {0x3880, 0x0001}) == 0); // the manual's example: 80000
    CHECK(b.drive.peek(0x110C) == 80'000);
    b.set(map::pair_word_order, 0);
    std::array<std::uint16_t, 2> words{};
    CHECK(b.drive.read(0x110C, words) == 0);
    CHECK(words[0] == 1);
    CHECK(words[1] == 0x3880);
    CHECK(b.write(0x110D, {0x3881}) == 0); // half a value is joined with the other half
    CHECK(b.drive.peek(0x110C) == 80'001);
    CHECK(b.write(0x110C, {0x7FFF}) == 3); // 0x7FFF3881 is out of range
}

TEST_CASE("64-bit values have their low half first in either word order") {
    bench b;
    b.set(map::encoder_type, map::encoder_kind::absolute);
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.set(map::target_speed, -3000);
    b.restart();
    b.enable();
    b.run(3000);
    for (const int order : {0, 1}) {
        b.set(map::pair_word_order, order);
        std::array<std::uint16_t, 4> words{};
        CHECK(b.drive.read(map::encoder_position_low.address, words) == 0);
        const u32 low = join_words(words[0], words[1], b.order());
        const u32 high = join_words(words[2], words[3], b.order());
        CHECK(high == 0xFFFF'FFFF); // below 0
        CHECK(static_cast<i32>(low) == b.drive.position());
    }
}

// When a write is taken and when it acts

TEST_CASE("parameters for the stopped drive are exception 4 while it is enabled or turns") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    CHECK(b.put(map::main_speed_source, 0) == 0);
    b.enable();
    CHECK(b.put(map::main_speed_source, 0) == 4);
    CHECK(b.get(map::last_bus_error) == map::bus_error::device_failure);
    CHECK(b.put(map::alarm_reset, 1) == 4);
    CHECK(b.put(map::software_reset, 1) == 4);
    CHECK(b.write(map::speed_segment_speeds[0].address, {100}) == 4);
    CHECK(b.put(map::target_speed, 500) == 0); // for the running one
    b.run(2000);
    b.virtual_levels(0);
    b.run(1);
    CHECK_FALSE(b.drive.enabled());
    CHECK_FALSE(b.drive.stands_still()); // it coasts
    CHECK(b.put(map::main_speed_source, 0) == 4);
    b.run_until_still();
    CHECK(b.put(map::main_speed_source, 0) == 0);
}

TEST_CASE("what takes effect at power-on raises Er.941 and waits for it") {
    bench b;
    b.set(map::pulses_per_revolution, 10'000); // no change
    CHECK_FALSE(b.drive.has_alarm(0x941));
    b.set(map::pulses_per_revolution, 20'000);
    CHECK(b.drive.has_alarm(0x941));
    CHECK(b.drive.is_active(out::warning));
    CHECK(b.get(map::pulses_per_revolution) == 20'000);
    CHECK(b.drive.in_force(map::pulses_per_revolution.address) == 10'000);
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_warning());
    CHECK(b.get(map::alarm_reset) == map::action::none);
    b.set(map::software_reset, 1); // counts as power-on
    CHECK(b.drive.in_force(map::pulses_per_revolution.address) == 20'000);
}

TEST_CASE("functions of terminals take effect when the motor is stopped") {
    bench b;
    b.assign({});
    b.restart();
    b.set(map::virtual_input_functions[1], in::gear_selection);
    CHECK(b.drive.in_force(map::virtual_input_functions[1].address) == 24);
    b.enable();
    b.set(map::virtual_input_functions[1], in::zero_clamp);
    b.run(10);
    CHECK(b.get(map::virtual_input_functions[1]) == in::zero_clamp);
    CHECK(b.drive.in_force(map::virtual_input_functions[1].address) == 24);
    b.virtual_levels(0);
    b.run(5);
    CHECK(b.drive.in_force(map::virtual_input_functions[1].address) == 12);
}

TEST_CASE("address and baud rate act at once") {
    bench b;
    b.set(map::node_address, 7);
    b.set(map::rs485_baud_rate, map::baud_rate::baud_9600);
    CHECK(b.drive.unit() == 7);
    CHECK(b.drive.baud() == 9600);
    b.restart();
    CHECK(b.drive.unit() == 7);
}

// The EEPROM

TEST_CASE("with P0C-13 = 1 every register outside P0B and P0D wears the EEPROM") {
    bench b;
    b.set(map::target_speed, 0);
    CHECK(b.drive.eeprom_writes() == 1);
    b.set(map::target_speed, 0); // the same again wears as well
    CHECK(b.drive.eeprom_writes() == 2);
    b.set(map::home_offset, 5);
    CHECK(b.drive.eeprom_writes() == 4);
    b.set(map::virtual_input_levels, 0);
    CHECK(b.drive.eeprom_writes() == 5);
    b.set(map::selected_fault_record, 3);
    b.set(map::emergency_stop, 0);
    CHECK(b.drive.eeprom_writes() == 5);
    b.set(map::eeprom_update, 0);
    CHECK(b.drive.eeprom_writes() == 6);
    for (int i = 0; i < 1000; ++i) b.set(map::target_speed, i);
    CHECK(b.drive.eeprom_writes() == 6);
    CHECK(b.drive.stored(map::target_speed.address) == 0);
    CHECK_FALSE(b.drive.has_warning());
}

TEST_CASE("power-on brings back what was stored, and P31-00 as 0") {
    bench b;
    b.set(map::target_speed, 77);
    b.set(map::virtual_input_levels, 0x8000);
    b.set(map::eeprom_update, 0);
    b.set(map::target_speed, 88);
    b.set(map::selected_fault_record, 9);
    b.restart();
    CHECK(b.get(map::target_speed) == 77);
    CHECK(b.get(map::virtual_input_levels).bits == 0);
    CHECK(b.get(map::eeprom_update) == map::off_on::off); // stored as it was written
    CHECK(b.get(map::selected_fault_record) == map::fault_record::current);

    bench c{{.stores_eeprom_off = false}};
    c.set(map::eeprom_update, 0);
    CHECK(c.drive.eeprom_writes() == 0);
    c.restart();
    CHECK(c.get(map::eeprom_update) == map::off_on::on);
}

TEST_CASE("more than 200 stored parameters within ten seconds raise Er.942") {
    bench b;
    for (int i = 0; i < 200; ++i) b.set(map::target_speed, i);
    CHECK_FALSE(b.drive.has_alarm(0x942));
    b.set(map::target_speed, 1);
    CHECK(b.drive.has_alarm(0x942));
    CHECK_FALSE(b.drive.has_fault());
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_alarm(0x942));

    bench slow;
    for (int i = 0; i < 500; ++i) {
        slow.set(map::target_speed, i);
        slow.run(60);
    }
    CHECK_FALSE(slow.drive.has_alarm(0x942));
}

TEST_CASE("P02-31 = 1 restores the factory's values but for P01, in force after the restart") {
    bench b;
    b.set(map::drive_number, 42);
    b.set(map::node_address, 9);
    b.set(map::rs485_baud_rate, map::baud_rate::baud_9600);
    b.set(map::data_format, map::serial_format::n81);
    b.set(map::pair_word_order, 0);
    b.set(map::target_speed, 1);
    b.set(map::eeprom_update, 0);
    b.set(map::initialise_parameters, map::initialisation::factory_defaults);
    CHECK(b.get(map::initialise_parameters) == map::initialisation::none);
    CHECK(b.drive.unit() == 9);
    CHECK(b.get(map::target_speed) == 1);
    b.restart();
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 57600);
    CHECK(b.get(map::data_format) == map::serial_format::n82);
    CHECK(b.get(map::pair_word_order) == map::pair_order::low_first);
    CHECK(b.get(map::eeprom_update) == map::off_on::on);
    CHECK(b.get(map::target_speed) == 200);
    CHECK(b.get(map::drive_number) == 42);
}

// Terminals

TEST_CASE("S-ON on a virtual input acts after a power cycle only") {
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

TEST_CASE("S-ON on an input and a virtual one is Er.130") {
    bench b;
    b.set(map::virtual_input_functions[0], in::servo_on);
    b.set(map::virtual_inputs_enable, 1);
    b.run(5);
    CHECK_FALSE(b.drive.has_fault()); // not in force yet
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

TEST_CASE("any function on two terminals is Er.130, as soon as it is in force") {
    bench b;
    b.set(map::virtual_input_functions[3], in::homing_start); // DI8 has it from the factory
    CHECK_FALSE(b.drive.has_fault());
    b.set(map::virtual_inputs_enable, 1);
    CHECK(b.drive.has_alarm(0x130));
    b.set(map::di8_function, 0);
    b.set(map::alarm_reset, 1);
    CHECK_FALSE(b.drive.has_fault());
}

TEST_CASE("P0C-10 gives the virtual levels at power-on") {
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
    b.set(map::di7_logic, map::input_logic::rising_edge); // a home switch knows levels only
    b.run(2);
    CHECK(b.drive.is_active(in::home_switch));
    // P03-03 = 1 enables at power-on
    b.set(map::di1_logic, map::input_logic::high_level);
    b.run(3);
    CHECK_FALSE(b.drive.enabled());
    b.drive.set_input(2, false);
    b.set(map::di2_logic, map::input_logic::low_level);
    b.restart();
    b.run(3);
    CHECK(b.drive.enabled());
}

TEST_CASE("P03-00 bit 0 enables at power-on") {
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

TEST_CASE("virtual outputs show their functions, or a level where they have none") {
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

TEST_CASE("ramps lead over 1000 r/min, limits hold, outputs follow") {
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

TEST_CASE("a lost bus does not stop the motor") {
    bench b;
    b.assign({});
    b.set(map::mode_of_operation, map::control_mode::speed);
    b.restart();
    b.enable();
    b.run(600'000);
    CHECK(b.get(map::actual_speed) == 200);
}

TEST_CASE("speed commands A and B, their sum, their switch, their direction, and the zero clamp") {
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

TEST_CASE("speed segments run once, in circles, or by inputs") {
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

// Position control

TEST_CASE("a step moves by P05-05 with each edge of FunIN.20") {
    bench b;
    b.assign({in::step_enable, in::position_direction, in::position_command_inhibit});
    b.set(map::position_command_source, map::position_source::step);
    b.set(map::position_step, 2500);
    b.restart();
    b.start(); // S-ON and the edge at once: the edge is lost
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

TEST_CASE("a segment chosen by inputs is moved once for each edge") {
    bench b;
    b.begin_segments(map::segment_mode::by_input, {in::segment_selection_1, in::segment_selection_2});
    CHECK(b.drive.is_active(out::positioning_completed));
    b.set(map::position_segment_displacements[2], 80'000);
    b.set(map::position_segment_speeds[2], 3000);
    b.set(map::position_segment_acceleration_times[2], 1000);
    b.virtual_levels(1 | 8);
    b.start(8);
    b.run(1);
    CHECK(b.drive.is_active(out::positioning_completed)); // still: a trap
    b.run(20);
    CHECK_FALSE(b.drive.is_active(out::positioning_completed));
    CHECK(b.get(map::position_deviation) > 0);
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

TEST_CASE("segments run once, in circles or from P11-05, relative or absolute, with waits") {
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

TEST_CASE("an interrupted run is finished or begun again by P11-02") {
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
    CHECK(b.drive.position() == 8 * turn); // 2^20 counts for 10000 units: 1250 units a turn
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

TEST_CASE("a blocked shaft is a deviation, Er.630 or Er.B00; FunIN.35 clears the deviation") {
    bench b;
    b.set(map::stall_protection, 0);
    b.begin_segments(map::segment_mode::single, {in::clear_position_deviation});
    b.drive.block_shaft(true);
    b.start();
    b.run(2000);
    CHECK(b.get(map::position_deviation) == 10'000);
    CHECK(b.get(map::encoder_position_deviation) == turn);
    CHECK_FALSE(b.drive.is_active(out::positioning_completed));
    b.virtual_levels(5);
    b.run(2);
    CHECK(b.get(map::position_deviation) == 0);
    b.drive.block_shaft(false);
    b.run(100);
    CHECK(b.drive.position() == 0);
    b.drive.block_shaft(true);
    b.set(map::position_deviation_limit, 50'000);
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

// Stopping

TEST_CASE("servo off coasts or stops at zero speed by P02-05") {
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

TEST_CASE("a brake delays the first command and the end of power") {
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

TEST_CASE("limit switches stop the motor by P02-07") {
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
        if (how != 1) { // S-ON is wanted anew
            b.virtual_levels(2);
            b.run(2);
            b.virtual_levels(3);
            b.run(100);
            CHECK(b.drive.enabled());
        }
        CHECK(b.drive.stands_still()); // forward is barred
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

TEST_CASE("an emergency stop ends at zero speed, locked, with Er.900; afterwards speed goes on") {
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

// Homing

namespace {
// Modes of P05-31 on a machine with a switch from 2.5 to 3.5 turns, limits at -10 and 10.
struct homing_bench : bench {
    explicit homing_bench(int mode, std::int64_t home_from = 5 * turn / 2,
                          std::int64_t home_to = 7 * turn / 2) {
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

TEST_CASE("homing begins on the switch, or turns round at a limit") {
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

TEST_CASE("the offset is the position at home, and electrical homing returns there") {
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

TEST_CASE("P05-30: 6 sets home at once, 1 and 2 wait for the input, 3 homes after power-on, 0 aborts") {
    bench b;
    b.begin_segments(map::segment_mode::single, {in::homing_start});
    b.start();
    b.run_until_still();
    CHECK(b.reference() == 10'000);
    b.set(map::homing_control, map::homing::set_home);
    CHECK(b.reference() == 0);
    CHECK(b.get(map::homing_control) == map::homing::off);
    CHECK(b.drive.in_force(map::homing_control.address) == 0);

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

// Alarms

TEST_CASE("a fault disables; it is reset with S-ON off only") {
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
    b.set(map::alarm_reset, 1); // S-ON is still given
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

TEST_CASE("every alarm is reset as its class says") {
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

TEST_CASE("an alarm comes back while its cause lasts") {
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

TEST_CASE("the last ten alarms are kept with what was measured") {
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
    CHECK(b.get(map::recorded_alarm) == 0); // record 0 is the alarm of now
    b.set(map::selected_fault_record, 1);
    CHECK(b.get(map::recorded_alarm) == 0x620);
    for (int i = 0; i < 12; ++i) {
        b.drive.raise(i % 2 == 0 ? 0x500 : 0x510);
        b.set(map::alarm_reset, 1);
    }
    b.restart(); // they outlast the power
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

TEST_CASE("faults of the absolute encoder want P0D-20, then P0D-01") {
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

TEST_CASE("an absolute encoder keeps its position over a power cycle, an incremental one does not") {
    for (const bool is_absolute : {false, true}) {
        bench b;
        b.set(map::encoder_type, is_absolute ? 1 : 0);
        b.begin_segments(map::segment_mode::single);
        b.start();
        b.run_until_still();
        CHECK(b.get(map::encoder_revolutions) == (is_absolute ? 1 : 0));
        b.virtual_levels(0);
        b.run(5);
        b.restart();
        CHECK(b.reference() == (is_absolute ? 10'000 : 0));
        b.set(map::reset_absolute_encoder, 2);
        CHECK(b.get(map::encoder_revolutions) == 0);
    }
}

TEST_CASE("a software reset is a restart") {
    bench b;
    b.assign({});
    b.set(map::eeprom_update, 0);
    b.set(map::target_speed, 5);
    b.virtual_levels(0x80);
    b.set(map::software_reset, 1);
    CHECK(b.get(map::target_speed) == 200);
    CHECK(b.get(map::virtual_input_levels).bits == 0);
    CHECK(b.get(map::software_reset) == map::action::none);
    b.enable(); // S-ON's new terminal is in force
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

TEST_CASE("an input's edges act as its logic says") {
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

TEST_CASE("S-ON on an edge enables nothing") {
    bench b;
    b.assign({});
    b.set(map::virtual_input_logics[0], 1);
    b.restart();
    b.virtual_levels(1);
    b.run(10);
    CHECK_FALSE(b.drive.enabled());
}

TEST_CASE("a brake on a virtual output delays commands too, unless a test wants otherwise") {
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

TEST_CASE("P05-20 decides what COIN waits for") {
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

TEST_CASE("P0D-01 is for the stopped drive, unless a test wants otherwise") {
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

TEST_CASE("overspeed and too high a voltage at an analogue input are faults") {
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

TEST_CASE("homing that was stored does not begin by itself; one that was ordered waits for S-ON") {
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

// On a line

TEST_CASE("a client reads and writes the drive, and takes either echo of a write") {
    for (const bool echoes : {false, true}) {
        simulated::c630s_rig rig{{.echoes_byte_count = echoes}};
        client on{rig.line, node<map::device>{1}};
        std::array<std::uint16_t, 1> seen{};
        CHECK(on.read_words(map::target_speed.address, seen) == failure{});
        CHECK(seen[0] == 200);
        std::uint16_t words[] = {0x3880, 1};
        CHECK(on.write_words(0x110C, words));
        CHECK(rig.model.peek(0x110C) == 80'000);
    }
}

TEST_CASE("a response waits for P0C-25") {
    simulated::c630s_rig rig;
    client on{rig.line, node<map::device>{1}};
    const auto took = [&] {
        std::array<std::uint16_t, 1> word{};
        const std::uint64_t before = rig.wire.time_us();
        CHECK(on.read_words(map::actual_speed.address, word) == failure{});
        return rig.wire.time_us() - before;
    };
    (void)took(); // the line is silent first
    const std::uint64_t fast = took();
    CHECK(on.write_word(map::response_delay.address, 50));
    const std::uint64_t slow = took();
    CAPTURE(fast);
    CAPTURE(slow);
    CHECK(about(static_cast<std::int64_t>(slow - fast), 48'500, 1'500));
}

TEST_CASE("jog ends a homing, and a power cycle everything but the motor's momentum") {
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

TEST_CASE("one run replays another") {
    const auto play = [] {
        bench b;
        b.begin_segments(map::segment_mode::cyclic);
        b.start();
        b.run(12'345);
        return b.drive.position();
    };
    CHECK(play() == play());
}
