// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The registers of the simulated YAKOTEC steppers: defaults, missing addresses, ranges, exceptions, the word
// order, and what a save and a restore keep. The last test accesses them over a line.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

namespace sim_yako_registers_tests {

using namespace servobus;
using namespace yako_bench;

// Registers

TEST_CASE_TEMPLATE("a new drive has every register of its catalogue at its default", B, BOTH) {
    B b;
    for (const entry& e : map_of<decltype(b.drive)>.entries) {
        CAPTURE(e.address);
        std::array<std::uint16_t, 2> words{};
        REQUIRE(b.drive.read(e.address, std::span<std::uint16_t>{words}.first(e.words())) == 0);
        if (e.rights == access::ro || e.initial == no_default) continue;
        CHECK(e.number(e.words() == 2 ? join_words(words[0], words[1], word_order::high_first) : words[0]) ==
              e.initial);
    }
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 115200);
    CHECK(b.get(cl::actual_node_address) == 1);
    CHECK(b.get(cl::dip_switches).is_on(1));
}

TEST_CASE_TEMPLATE("a missing address causes exception 3, one beyond the last address exception 4", B, BOTH) {
    B b;
    const catalogue& map = map_of<decltype(b.drive)>;
    const unsigned last = map.entries.back().address;
    for (unsigned address = 0; address <= 0xFFFF; ++address) {
        const auto at = static_cast<std::uint16_t>(address);
        const int wanted = address > last ? 4 : map.find(at) == nullptr ? 3 : 0;
        std::array<std::uint16_t, 1> word{};
        if (b.drive.read(at, word) != wanted) FAIL_CHECK("read of " << address);
        if (wanted != 0 && b.write(at, 0) != wanted) FAIL_CHECK("write to " << address);
    }
    std::array<std::uint16_t, 17> words{};
    CHECK(b.drive.read(0x0020, std::span<std::uint16_t>{words}.first(6)) == 0);
    CHECK(b.drive.read(0x0020, std::span<std::uint16_t>{words}.first(7)) == 3);
    CHECK(b.drive.read(0x0060, std::span<std::uint16_t>{words}.first(16)) == 0);
    CHECK(b.drive.read(0x0060, words) == 5);
    CHECK(b.drive.read(0x0020, words) == 5); // this check precedes that for missing addresses
    CHECK(b.drive.read(static_cast<std::uint16_t>(last), std::span<std::uint16_t>{words}.first(2)) == 4);
}

TEST_CASE_TEMPLATE("values at the ends of a range are accepted, those beyond cause exception 7, and writes "
                   "of read-only rows exception 6",
                   B, BOTH) {
    for (const entry& e : map_of<decltype(B{}.drive)>.entries) {
        CAPTURE(e.address);
        B b;
        if (e.rights == access::ro) {
            CHECK(b.write(e.address, 0) == 6);
            continue;
        }
        if (e.words() == 2) {
            CHECK(b.write(e.address, {e.limits.low >> 16, e.limits.low & 0xFFFF}) == 0);
            CHECK(b.write(e.address, {e.limits.high >> 16, e.limits.high & 0xFFFF}) == 0);
            continue;
        }
        if (e.limits.low >= 0 || e.address != cl::homing_method.address)
            CHECK(b.write(e.address, e.limits.low) == 0);
        CHECK(b.write(e.address, e.limits.high) == 0);
        if (e.limits.high < 0xFFFF) CHECK(b.write(e.address, e.limits.high + 1) == 7);
        if (e.limits.low > (e.is_signed() ? -0x8000 : 0)) CHECK(b.write(e.address, e.limits.low - 1) == 7);
    }
}

TEST_CASE_TEMPLATE("only the homing methods of the variant are accepted", B, BOTH) {
    B b;
    constexpr bool has_encoder = std::is_same_v<B, closed>;
    for (int n = -10; n <= 45; ++n) {
        CAPTURE(n);
        const bool is_common = (n >= 17 && n <= 30) || n == 35;
        const bool is_extra = (n >= -4 && n <= -1) || (n >= 1 && n <= 14) || n == 33 || n == 34;
        CHECK(b.write(0x0031, n) == (is_common || (has_encoder && is_extra) ? 0 : 7));
    }
}

TEST_CASE("the manual's own example frames give exceptions with the vendor's numbers") {
    sim::yako_open_loop drive;
    modbus::server<sim::yako_open_loop> server{1, drive,
                                               modbus::timing_at(115200, modbus::timing_mode::strict)};
    instant now{1000};
    const auto answer = [&](bytes request) {
        now = now + milliseconds(10);
        server.elapse(now);
        server.feed(request, now);
        now = now + milliseconds(10);
        server.elapse(now); // the end of a function without a length
        now = now + milliseconds(10);
        const bytes frame = server.response(now);
        const std::vector<std::uint8_t> copy{frame.begin(), frame.end()};
        if (!copy.empty()) server.sent(now);
        return copy;
    };
    CHECK(same_bytes(answer(hex("01 02 00 00 00 04 79 C9")), hex("01 82 02 C1 61")));
    CHECK(same_bytes(answer(hex("01 03 00 3C 00 01 44 06")), hex("01 83 03 01 31")));
    CHECK(same_bytes(answer(hex("01 06 FF 00 FF FF B8 6E")), hex("01 86 04 43 A3")));
    CHECK(same_bytes(answer(hex("01 03 00 20 00 20 45 D8")), hex("01 83 05 81 33")));
    CHECK(same_bytes(answer(hex("01 06 00 00 00 01 48 0A")), hex("01 86 06 C2 62")));
    CHECK(same_bytes(answer(hex("01 06 00 20 FF FF 89 B0")), hex("01 86 07 03 A2")));
    CHECK(answer(hex("01 03 00 20 00 01 85 C1")).empty()); // bad CRC
    CHECK(!answer(hex("01 03 00 20 00 01 85 C0")).empty());
}

TEST_CASE("G14: an address range that wraps is refused, and requests with wrong counts write nothing") {
    sim::yako_closed_loop drive;
    std::array<std::uint8_t, modbus::max_pdu> out{};
    const auto refusal = [&](bytes pdu) {
        CHECK(modbus::respond(drive, pdu, out, drive.rules()) == 2);
        return out[1];
    };
    CHECK(refusal(hex("03 FF FF 00 02")) == 4);
    CHECK(refusal(hex("03 00 20 00 00")) == 5);
    CHECK(refusal(hex("03 00 20 00 11")) == 5);
    CHECK(refusal(hex("10 00 20 00 02 04 00 01 00")) == 5);
    CHECK(refusal(hex("10 00 20 00 02 03 00 01 00")) == 5);
    CHECK(refusal(hex("04 00 20 00 01")) == 2);
    CHECK(drive.writes() == 0);
}

TEST_CASE("G14, A4: a bad CRC gets no response, or exception 1 if the option is set; frames of other nodes "
          "and broadcasts never get one") {
    sim::yako_closed_loop drive{{.answers_bad_crc = true}};
    modbus::server<sim::yako_closed_loop> server{1, drive, modbus::timing_at(115200)};
    server.feed(hex("01 03 00 20 00 01 85 C1"), instant{1000});
    CHECK(same_bytes(server.response(instant{20'000}), hex("01 83 01 80 F0")));
    server.sent(instant{21'000});
    server.feed(hex("02 03 00 20 00 01 85 C1"), instant{40'000});
    server.elapse(instant{60'000});
    CHECK(server.response(instant{60'000}).empty());
    server.feed(hex("00 06 00 20 00 01 85 C1"), instant{80'000});
    server.elapse(instant{99'000});
    CHECK(server.response(instant{99'000}).empty());
    server.feed(hex("01 03 00 20 00 01 85 C0"), instant{120'000}); // receives again
    CHECK(!server.response(instant{140'000}).empty());
    CHECK(drive.writes() == 0);
}

TEST_CASE("G14: a write of several registers is executed completely or not at all") {
    closed b;
    CHECK(b.write(0x0020, {10, 100, 3000}) == 7);
    CHECK(b.write(0x0024, {0, 1, 0}) == 3);
    CHECK(b.write(0x0007, 0) == 6);
    CHECK(b.get(cl::start_speed) == 30);
    CHECK(b.drive.writes() == 0);
    CHECK(b.write(0x0020, {10, 100, 100, 60, 0, 1000}) == 0); // section 4.1 as it is meant [errata A2]
    CHECK(b.get(cl::target_position) == 1000);
    CHECK(b.drive.writes() == 6);
    CHECK(b.drive.writes_to(0x0023) == 1);
    CHECK(b.drive.last_write(0).value == 1000);
    CHECK(b.drive.last_write(6).ordinal == 0);
}

TEST_CASE_TEMPLATE("0019h changes the word order of every 32-bit value immediately, and affects no other "
                   "register",
                   B, BOTH) {
    B b;
    b.set(cl::target_position, 0x00123456);
    b.set(cl::homing_ramp_time, 777);
    b.drive.push_shaft(-5);
    b.set(cl::pair_word_order, 1);
    CHECK(b.drive.peek(0x0024) == 0x3456);
    CHECK(b.drive.peek(0x0025) == 0x0012);
    CHECK(b.drive.peek(0x0060) == 5000);
    CHECK(b.drive.peek(0x0061) == 0);
    CHECK(b.drive.peek(0x0034) == 777);
    CHECK(b.write(0x0035, {7, 0xFFFF}) == 0);
    b.set(cl::pair_word_order, 0);
    CHECK(b.get(cl::home_offset) == -0x10000 + 7);
    if (!std::is_same_v<B, closed>) return;
    CHECK(b.position() == -5);
    b.set(cl::pair_word_order, 1);
    CHECK(b.drive.peek(0x000A) == 0xFFFB);
}

// Memory

TEST_CASE_TEMPLATE("a save stores every writable register; it is ignored while the motor moves", B, BOTH) {
    B b;
    b.set(cl::positioning_speed, 111);
    b.set(cl::pair_word_order, 1);
    b.write(0x0060, {77, 1});
    b.command(motion_code::jog());
    b.run(10);
    b.command(auxiliary::save_parameters);
    CHECK(b.drive.eeprom_writes() == 0);
    b.command(motion_code::emergency_stop());
    b.command(auxiliary::save_parameters);
    CHECK(b.drive.saves() == 1);
    CHECK(b.drive.eeprom_writes() > 180);
    b.set(cl::positioning_speed, 222);
    b.drive.power_cycle();
    CHECK(b.get(cl::positioning_speed) == 111);
    CHECK(b.get(cl::pair_word_order) == servobus::yako::word_order_setting::low_first);
    CHECK(b.drive.peek(0x0060) == 77);
    CHECK(b.drive.peek(0x0061) == 1);
}

TEST_CASE("without a save a power cycle resets the registers; the position is 0 and not homed") {
    closed b;
    b.set(cl::positioning_speed, 111);
    b.set(cl::homing_method, 35);
    b.command(motion_code::home());
    b.run(10);
    CHECK(b.status().is_homed());
    b.move(500);
    b.run_until_still();
    b.drive.power_cycle();
    CHECK(b.get(cl::positioning_speed) == 60);
    CHECK(b.position() == 0);
    CHECK(!b.status().is_homed());
    CHECK(b.status().is_enabled());
    CHECK(b.drive.view().shaft == 500);
    CHECK(b.drive.eeprom_writes() == 0);
    CHECK(!closed{{.is_enabled_at_power_on = false}}.status().is_enabled());
}

TEST_CASE("a restore sets the defaults, only at standstill") {
    closed b;
    b.set(cl::positioning_speed, 111);
    b.command(auxiliary::save_parameters);
    b.command(motion_code::jog());
    b.run(10);
    b.command(auxiliary::restore_parameters);
    CHECK(b.get(cl::positioning_speed) == 111);
    b.command(motion_code::emergency_stop());
    b.command(auxiliary::restore_parameters);
    CHECK(b.get(cl::positioning_speed) == 60);
    b.drive.power_cycle();
    CHECK(b.get(cl::positioning_speed) == 60);
}

TEST_CASE("address and baud rate take effect at the next power-on; the switches override 0013h") {
    closed b;
    b.set(cl::node_address, 42);
    b.set(cl::rs485_baud_rate, 2);
    b.command(auxiliary::save_parameters);
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 115200);
    b.drive.power_cycle();
    CHECK(b.drive.address() == 1);
    CHECK(b.drive.baud() == 19200);
    b.drive.set_switches(0x60); // none of the five address switches
    CHECK(b.drive.address() == 1);
    b.drive.power_cycle();
    CHECK(b.drive.address() == 42);
    CHECK(b.get(cl::actual_node_address) == 42);
    CHECK(b.get(cl::dip_switches).is_on(6));
}

// On a line

TEST_CASE("a client on a line reads and writes the drive, and reads its word order") {
    simulated::simulated_closed_loop rig;
    client<simulated::simulated_closed_loop::line_type, cl::device> c{rig.line, node<cl::device>{1}};
    CHECK(!c.read<cl::actual_position>());
    REQUIRE(c.learn_word_order() == errc::ok);
    REQUIRE(c.write<cl::target_position>(checked(2500)));
    REQUIRE(c.write<cl::motion_command>(motion_code::move(positioning::absolute)));
    rig.run(5000);
    const auto at = c.read<cl::actual_position>();
    REQUIRE(at);
    CHECK(at->count() == 2500);
    CHECK(rig.sent(hex("01 06 00 27 00 05 F9 C2")) == 1);
    CHECK(rig.model.view().position == 2500);
}

} // namespace sim_yako_registers_tests
