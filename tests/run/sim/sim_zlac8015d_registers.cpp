// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers of the simulated ZLAC8015D: defaults, ranges, exceptions, blocks, and what a save, a power
// cycle and a factory reset keep.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_registers_tests {

using namespace servobus;
using namespace zlac8015d_bench;

// Registers

TEST_CASE("a new drive has every register of the catalogue at its default") {
    bench b;
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        std::array<std::uint16_t, 2> words{};
        REQUIRE(b.drive.read(e.address, std::span<std::uint16_t>{words}.first(e.words())) == 0);
        if (e.rights == access::ro || e.initial == no_default) continue;
        const std::uint32_t bits =
            e.words() == 2 ? join_words(words[0], words[1], word_order::high_first) : words[0];
        CHECK(e.number(bits) == e.initial);
    }
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 115200);
}

TEST_CASE("a missing address causes exception 2, alone and inside a block") {
    bench b;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const auto at = static_cast<std::uint16_t>(address);
        const bool exists = map::catalogue.find(at) != nullptr;
        std::array<std::uint16_t, 1> word{};
        if (b.drive.read(at, word) != (exists ? 0 : 2)) FAIL_CHECK("read of " << address);
        if (!exists && b.write(at, 0) != 2) FAIL_CHECK("write to " << address);
    }
    std::array<std::uint16_t, 8> words{};
    CHECK(b.drive.read(0x2010, words) == 2); // 2015h is a gap
    CHECK(b.drive.read(0x20AF, std::span<std::uint16_t>{words}.first(3)) == 2);
    CHECK(b.drive.read(0x2088, words) == 0);
}

TEST_CASE(
    "values at the ends of a range are accepted, those beyond cause exception 3, and writes of read-only "
    "rows exception 2") {
    for (const entry& e : map::catalogue.entries) {
        CAPTURE(e.address);
        bench b;
        const auto put = [&](std::int64_t v) {
            return e.words() == 2 ? b.write(e.address, {v >> 16, v & 0xFFFF}) : b.write(e.address, v);
        };
        if (e.rights == access::ro) {
            CHECK(put(0) == 2);
            continue;
        }
        CHECK(put(e.limits.low) == 0);
        CHECK(put(e.limits.high) == 0);
        const bool is_packed_full = !e.limits.is_stated;
        if (is_packed_full) continue;
        CHECK(put(e.limits.high + 1) == 3);
        CHECK(put(e.limits.low - 1) == 3);
    }
}

TEST_CASE("only the codes of the control word are accepted") {
    for (unsigned code = 0; code <= 0x13; ++code) {
        bench b;
        const bool is_code = code == 0 || (code >= 5 && code <= 8) || (code >= 0x10 && code <= 0x12);
        CHECK(b.write(0x200E, code) == (is_code ? 0 : 3));
    }
}

TEST_CASE("G14: a write of several registers is executed completely or not at all") {
    bench b;
    CHECK(b.write(0x2080, {100, 200, 40000}) == 3);
    CHECK(b.write(0x2013, {0, 1, 0}) == 2); // 2015h is a gap
    CHECK(b.write(0x2091, {1000, 0}) == 2); // 2092h does not exist
    CHECK(b.get(map::left_acceleration_time) == 500);
    CHECK(b.get(map::right_target_torque) == 0);
    CHECK(b.drive.writes() == 0);
    CHECK(b.write(0x2080, {100, 200, 300}) == 0);
    CHECK(b.get(map::left_deceleration_time) == 300);
}

TEST_CASE("a 32-bit value may be written word by word") {
    bench b;
    CHECK(b.write(0x208A, -1) == 0);
    CHECK(b.write(0x208B, -5) == 0);
    CHECK(b.get(map::left_target_position) == -5);
    CHECK(b.write(0x208A, {0x8000, 0}) == 3);
}

TEST_CASE("writes are counted by register and logged in order") {
    bench b;
    b.command(control_code::stop);
    CHECK(b.write(0x2088, {1, 2}) == 0);
    CHECK(b.drive.writes_to(0x2088) == 1);
    CHECK(b.drive.writes_to(0x1234) == 0);
    CHECK(b.drive.commands(control_code::stop) == 1);
    CHECK(b.drive.last_write(0).address == 0x2089);
    CHECK(b.drive.last_write(2).address == 0x200E);
    CHECK(b.drive.last_write(2).value == 7);
    CHECK(b.drive.last_write(3).ordinal == 0);
    for (int i = 0; i < 200; ++i) b.set(map::left_target_speed, i);
    CHECK(b.drive.last_write(63).value == 136);
    CHECK(b.drive.last_write(64).ordinal == 0);
}

// Memory

TEST_CASE("G17: only saved values survive a power cycle, and the writes to the EEPROM are counted") {
    std::uint32_t saved_rows = 0;
    for (const entry& e : map::catalogue.entries) saved_rows += has(e.flags, saved) ? 1u : 0u;
    bench b;
    b.set(map::max_motor_speed, 300);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 1000);
    CHECK(b.drive.eeprom_writes() == 0);
    b.set(map::max_motor_speed, 300);
    b.set(map::left_acceleration_time, 100); // RW without S
    b.set(map::save_parameters, 1);
    CHECK(b.get(map::save_parameters) == map::parameter_save::none);
    CHECK(b.drive.saves() == 1);
    CHECK(b.drive.eeprom_writes() == saved_rows);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 300);
    CHECK(b.get(map::left_acceleration_time) == 500);
}

TEST_CASE(
    "G21: after a power cycle mode, control word, targets and feedback are zero and the drive is disabled") {
    bench b;
    b.begin(operating_mode::velocity);
    b.set(map::left_target_speed, 100);
    b.run(1000);
    b.drive.power_cycle();
    CHECK(b.get(map::mode_of_operation) == operating_mode::undefined);
    CHECK(b.get(map::control_word) == control_code::undefined);
    CHECK(b.get(map::left_target_speed) == 0);
    CHECK(b.get(map::left_actual_position) == 0);
    CHECK(!b.drive.enabled());
    CHECK(!b.drive.stands_still()); // the wheel coasts
    CHECK(b.run_until_still() > 500);
}

TEST_CASE("with 2007h = 1 the shaft is locked at power-on without being enabled") {
    bench b;
    b.set(map::shaft_at_power_on, 1);
    b.set(map::save_parameters, 1);
    CHECK(b.status().left.shaft == shaft_state::released);
    b.drive.power_cycle();
    CHECK(b.status().left.shaft == shaft_state::locked);
    CHECK(!b.drive.enabled());
    b.command(control_code::stop);
    CHECK(b.status().left.shaft == shaft_state::released);
}

TEST_CASE("a factory reset restores all registers, only while the drive is disabled") {
    bench b;
    b.set(map::max_motor_speed, 300);
    b.set(map::left_target_torque, 77);
    b.set(map::save_parameters, 1);
    b.begin(operating_mode::relative_position);
    b.set(map::restore_parameters, 1);
    CHECK(b.get(map::max_motor_speed) == 300);
    b.command(control_code::stop);
    b.run(10);
    b.set(map::restore_parameters, 1);
    CHECK(b.get(map::max_motor_speed) == 1000);
    CHECK(b.get(map::left_target_torque) == 0);
    b.drive.power_cycle();
    CHECK(b.get(map::max_motor_speed) == 1000);
}

} // namespace sim_zlac8015d_registers_tests
