// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers of the simulated C630S: defaults, ranges, 32-bit values, when a write is accepted and when it
// takes effect, what the EEPROM stores, and what a restart keeps. The last tests access them over a line.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include <servobus/client/client.hpp>
#include <servobus/sim/c630s.hpp>

#include <tests/support/c630s_bench.hpp>
#include <tests/support/simulated_c630s.hpp>

namespace sim_c630s_registers_tests {

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
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 57600);
    CHECK(b.drive.eeprom_writes() == 0);
    CHECK_FALSE(b.drive.has_fault());
    CHECK_FALSE(b.drive.enabled());
}

TEST_CASE("a missing address causes exception 2, alone and inside a block") {
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
    "values at the ends of a range are accepted, those beyond cause exception 3, and writes of read-only "
    "rows exception 2") {
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

TEST_CASE("gaps in a range cause exception 3, and a block is written completely or not at all") {
    bench b;
    CHECK(b.put(map::homing_control, 7) == 3);
    CHECK(b.put(map::auxiliary_speed_source, 4) == 3);
    CHECK(b.put(map::pulse_command_form, 3) == 3);
    CHECK(b.write(map::acceleration_time.address, {300, 400, 7000}) == 3); // P06-07 ends at 6000
    CHECK(b.get(map::acceleration_time) == 200);
    CHECK(b.write(map::acceleration_time.address, {300, 400, 4000}) == 0);
    CHECK(b.get(map::deceleration_time) == 400);
    CHECK(b.drive.writes() == 3);
    CHECK(b.drive.last_write(2).address == map::acceleration_time.address);
    CHECK(b.drive.last_write().value == 4000);
}

TEST_CASE("32-bit values are read and written in the word order of P0C-26, which takes effect immediately") {
    bench b;
    CHECK(b.write(0x110C, {0x3880, 0x0001}) == 0); // the manual's example: 80000
    CHECK(b.drive.peek(0x110C) == 80'000);
    b.set(map::pair_word_order, 0);
    std::array<std::uint16_t, 2> words{};
    CHECK(b.drive.read(0x110C, words) == 0);
    CHECK(words[0] == 1);
    CHECK(words[1] == 0x3880);
    CHECK(b.write(0x110D, {0x3881}) == 0); // one word is combined with the other one
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
        const u32 low = join_words(words[0], words[1], b.current_word_order());
        const u32 high = join_words(words[2], words[3], b.current_word_order());
        CHECK(high == 0xFFFF'FFFF); // below 0
        CHECK(static_cast<i32>(low) == b.drive.position());
    }
}

// When a write is accepted and when it takes effect

TEST_CASE("parameters for the stopped drive cause exception 4 while it is enabled or turns") {
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
    CHECK(b.put(map::target_speed, 500) == 0); // this parameter may be set while running
    b.run(2000);
    b.virtual_levels(0);
    b.run(1);
    CHECK_FALSE(b.drive.enabled());
    CHECK_FALSE(b.drive.stands_still()); // it coasts
    CHECK(b.put(map::main_speed_source, 0) == 4);
    b.run_until_still();
    CHECK(b.put(map::main_speed_source, 0) == 0);
}

TEST_CASE("a parameter that takes effect at power-on raises Er.941 and waits for the power-on") {
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

TEST_CASE("address and baud rate take effect immediately") {
    bench b;
    b.set(map::node_address, 7);
    b.set(map::rs485_baud_rate, map::baud_rate::baud_9600);
    CHECK(b.drive.address() == 7);
    CHECK(b.drive.baud() == 9600);
    b.restart();
    CHECK(b.drive.address() == 7);
}

// The EEPROM

TEST_CASE("with P0C-13 = 1 each write of a register outside P0B and P0D wears the EEPROM") {
    bench b;
    b.set(map::target_speed, 0);
    CHECK(b.drive.eeprom_writes() == 1);
    b.set(map::target_speed, 0); // the same value again also wears it
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

TEST_CASE("power-on restores the stored values, and sets P31-00 to 0") {
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

TEST_CASE("P02-31 = 1 restores the factory settings except P01, which take effect after the restart") {
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
    CHECK(b.drive.address() == 9);
    CHECK(b.get(map::target_speed) == 1);
    b.restart();
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 57600);
    CHECK(b.get(map::data_format) == map::serial_format::n82);
    CHECK(b.get(map::pair_word_order) == map::word_order_setting::low_first);
    CHECK(b.get(map::eeprom_update) == map::off_on::on);
    CHECK(b.get(map::target_speed) == 200);
    CHECK(b.get(map::drive_number) == 42);
}

// Restarts

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
    b.enable(); // the new terminal of S-ON is in effect
}

// On a line

TEST_CASE("a client reads and writes the drive, and accepts both forms of the response to a write") {
    for (const bool echoes : {false, true}) {
        simulated::simulated_c630s rig{{.echoes_byte_count = echoes}};
        client on{rig.line, node<map::device>{1}};
        std::array<std::uint16_t, 1> seen{};
        CHECK(on.read_words(map::target_speed.address, seen) == errc::ok);
        CHECK(seen[0] == 200);
        std::uint16_t words[] = {0x3880, 1};
        CHECK(on.write_words(0x110C, words));
        CHECK(rig.model.peek(0x110C) == 80'000);
    }
}

TEST_CASE("P0C-25 delays a response") {
    simulated::simulated_c630s rig;
    client on{rig.line, node<map::device>{1}};
    const auto took = [&] {
        std::array<std::uint16_t, 1> word{};
        const std::uint64_t before = rig.wire.time_us();
        CHECK(on.read_words(map::actual_speed.address, word) == errc::ok);
        return rig.wire.time_us() - before;
    };
    (void)took(); // waits for the gap first
    const std::uint64_t fast = took();
    CHECK(on.write_word(map::response_delay.address, 50));
    const std::uint64_t slow = took();
    CAPTURE(fast);
    CAPTURE(slow);
    CHECK(about(static_cast<std::int64_t>(slow - fast), 48'500, 1'500));
}

} // namespace sim_c630s_registers_tests
