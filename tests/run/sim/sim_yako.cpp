// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated YAKOTEC steppers: that they behave as documented, so that tests of programs may lean on them.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <tests/support/simulated_yako.hpp>
#include <tests/support/yako_bench.hpp>

using namespace servobus;
using namespace yako_bench;

#define BOTH closed, open

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
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 115200);
    CHECK(b.get(cl::actual_node_address) == 1);
    CHECK(b.get(cl::dip_switches).is_on(1));
}

TEST_CASE_TEMPLATE("a gap is exception 3, an address beyond the last one 4", B, BOTH) {
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
    CHECK(b.drive.read(0x0020, words) == 5); // judged before the gap inside
    CHECK(b.drive.read(static_cast<std::uint16_t>(last), std::span<std::uint16_t>{words}.first(2)) == 4);
}

TEST_CASE_TEMPLATE("values at the ends of their range are taken, beyond is 7, read-only 6", B, BOTH) {
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

TEST_CASE_TEMPLATE("only the methods that the variant has are taken", B, BOTH) {
    B b;
    constexpr bool has_encoder = std::is_same_v<B, closed>;
    for (int n = -10; n <= 45; ++n) {
        CAPTURE(n);
        const bool is_common = (n >= 17 && n <= 30) || n == 35;
        const bool is_extra = (n >= -4 && n <= -1) || (n >= 1 && n <= 14) || n == 33 || n == 34;
        CHECK(b.write(0x0031, n) == (is_common || (has_encoder && is_extra) ? 0 : 7));
    }
}

TEST_CASE("the manual's own frames for exceptions, with the vendor's numbers") {
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

TEST_CASE("G14: an address range that wraps is beyond the range, and wrong counts never write") {
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

TEST_CASE("G14, A4: a bad CRC meets silence, or exception 1 if it is asked for; other units' never") {
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
    server.feed(hex("01 03 00 20 00 01 85 C0"), instant{120'000}); // hears again
    CHECK(!server.response(instant{140'000}).empty());
    CHECK(drive.writes() == 0);
}

TEST_CASE("G14: a write of several registers is all or nothing") {
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

TEST_CASE_TEMPLATE("0019h turns every 32-bit value at once, and no other register", B, BOTH) {
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

// Moves

TEST_CASE_TEMPLATE("a relative move ends exactly, in the time of its trapezoid", B, BOTH) {
    B b;
    b.run(20);
    b.set(cl::start_speed, 0);
    b.set(cl::positioning_speed, 600); // 10000 pulses/s
    b.set(cl::acceleration_time, 200);
    b.set(cl::deceleration_time, 300);
    b.move(10'000);
    CHECK(about(b.run_until_still(), 2 + 1000 + 250, 15));
    CHECK(b.position() == 10'000);
    CHECK(b.drive.view().shaft == 10'000);
    CHECK(b.status().is_in_position());
    b.move(-3'000);
    b.run(220);
    CHECK(b.speed() == -600);
    b.run_until_still();
    CHECK(b.position() == 7'000);
    b.move(-100, positioning::absolute);
    b.run_until_still();
    CHECK(b.position() == -100);
    CHECK(b.drive.starts() == 3);
}

TEST_CASE("a move begins and ends with the start speed") {
    closed b;
    b.set(cl::start_speed, 60);
    b.set(cl::positioning_speed, 300);
    b.set(cl::acceleration_time, 1000);
    b.move(20'000);
    b.run_us(2250);
    CHECK(about(b.drive.view().speed, 60 * one_r_per_min, one_r_per_min));
    b.run(400);
    CHECK(about(b.speed(), 180, 3));
}

TEST_CASE_TEMPLATE("status and motion come a little after the acknowledged start", B, BOTH) {
    B b{{.start_delay = milliseconds(5)}};
    b.run(20);
    CHECK(b.status().to_word() == motion_status::in_position_bit);
    b.move(1000);
    b.run_us(4500);
    CHECK(b.status().to_word() == motion_status::in_position_bit);
    CHECK(b.position() == 0);
    b.order(command::jog()); // ignored: a start is under way
    b.run_us(750);
    CHECK(b.status().to_word() == motion_status::moving_bit);
    b.run_until_still();
    CHECK(b.position() == 1000);
    CHECK(b.drive.starts() == 1);
    b.move(1000);
    b.order(command::stop()); // before it began
    b.run(100);
    CHECK(b.position() == 1000);
}

TEST_CASE("in position comes 010Ch after the standstill, also after a stop") {
    closed b;
    b.set(cl::in_position_time, 50);
    b.order(command::jog());
    b.run(200);
    b.order(command::emergency_stop());
    b.run(1);
    CHECK(b.status().to_word() == 0);
    b.run(45);
    CHECK(!b.status().is_in_position());
    b.run(5);
    CHECK(b.status().is_in_position());
}

TEST_CASE("while moving, a new move is ignored without bit 3 and carried out at once with it") {
    closed b;
    b.move(10'000);
    b.run(100);
    b.move(5, positioning::absolute);
    CHECK(b.drive.starts() == 1);
    b.run(100);
    b.move(-500, positioning::absolute, while_moving::interrupt);
    CHECK(b.drive.starts() == 2);
    b.run_until_still();
    CHECK(b.position() == -500);
    b.order(command::jog());
    b.run(300);
    const std::int64_t at = b.drive.view().commanded;
    b.move(2000, positioning::relative, while_moving::interrupt); // from where it is
    b.run_until_still();
    CHECK(b.drive.view().commanded == at + 2000);
}

TEST_CASE_TEMPLATE("jog runs by the sign of 001Dh until a stop", B, BOTH) {
    B b;
    b.set(cl::jog_speed, -300);
    b.set(cl::jog_acceleration_time, 400);
    b.order(command::jog());
    b.run(202);
    CHECK(about(b.speed(), -150, 2));
    b.run(300);
    CHECK(b.speed() == -300);
    b.set(cl::jog_speed, 100); // for the next one
    b.order(command::jog());
    b.order(command::home());
    b.run(50);
    CHECK(b.speed() == -300);
    CHECK(b.drive.starts() == 1);
    CHECK(b.status().is_moving());
}

TEST_CASE("a stop takes the deceleration time that was set before the start") {
    closed b;
    b.set(cl::jog_deceleration_time, 1000);
    b.order(command::jog());
    b.run(300);
    b.set(cl::jog_deceleration_time, 0);
    b.order(command::stop());
    b.run(500);
    CHECK(about(b.speed(), 60, 2));
    b.run(510);
    CHECK(!b.status().is_moving());

    b.set(cl::deceleration_time, 0);
    b.move(100'000);
    b.run(300);
    b.set(cl::deceleration_time, 2000);
    b.order(command::stop());
    b.run(1);
    CHECK(!b.status().is_moving());
}

TEST_CASE("an emergency stop stands within a tick, and wins over a start in the same word") {
    closed b;
    b.set(cl::jog_speed, 3000);
    b.order(command::jog());
    b.run(300);
    b.order(command::emergency_stop());
    const std::int64_t at = b.drive.view().shaft;
    b.run(100);
    CHECK(b.drive.view().shaft == at);
    CHECK(b.status().is_enabled());
    b.set(cl::motion_command, 0x0201);
    b.run(10);
    CHECK(!b.status().is_moving());
    CHECK(b.drive.starts() == 1);
    CHECK(b.get(cl::motion_command).to_word() == 0);
}

TEST_CASE("0010h turns the motor the other way and keeps the position's value") {
    closed b;
    b.move(300);
    b.run_until_still();
    b.set(cl::motion_direction, 1);
    CHECK(b.position() == 300);
    b.move(100);
    b.run_until_still();
    CHECK(b.position() == 400);
    CHECK(b.drive.view().shaft == 200);
    b.move(0, positioning::absolute);
    b.run(20);
    b.set(cl::motion_direction, 0); // at the next standstill
    b.run(20);
    CHECK(b.position() < 400);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 600);
    CHECK(b.position() == 0);
    b.move(100);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 700);
}

TEST_CASE("0011h sets the pulses of a turn") {
    closed b;
    b.set(cl::microstep_resolution, 4000);
    b.set(cl::jog_speed, 60);
    b.set(cl::jog_acceleration_time, 0);
    b.order(command::jog());
    b.run(1002);
    CHECK(about(b.position(), 4000, 20));
    b.order(command::emergency_stop());
    const std::int32_t at = b.position();
    b.run(1);
    b.set(cl::microstep_resolution, 1000);
    CHECK(b.position() == at);
    CHECK(about(b.drive.view().shaft, at / 4, 1));
}

TEST_CASE("0011h turns lost steps and a machine's places into its pulses") {
    open b;
    b.drive.push_shaft(100);
    b.set(cl::microstep_resolution, 4000);
    CHECK(b.drive.view().shaft == 400);
    CHECK(b.drive.view().commanded == 0);
    sim::yako_machine m = simulated::yako_slide();
    m.home_from = -4; // 1.6 of 400 pulses before 0
    b.drive.attach(m);
    b.set(cl::microstep_resolution, 400);
    b.set(cl::homing_slow_speed, 5);
    b.order(command::home());
    b.run(5);
    b.run_until_still();
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == -2);
}

TEST_CASE("001Ah rescales what was written and what is read, on closed loop") {
    closed b;
    b.set(cl::jog_speed, 600);
    b.set(cl::speed_resolution, 1);
    b.order(command::jog());
    b.run(300);
    CHECK(b.drive.view().speed == 60 * one_r_per_min);
    CHECK(b.speed() == 600);
    b.set(cl::speed_resolution, 0);
    CHECK(b.speed() == 60);
    CHECK(open{}.write(0x001A, 0) == 3);
}

// 002Dh

TEST_CASE_TEMPLATE("release coasts, bit 4 says released, and starts are ignored until enabled", B, BOTH) {
    B b;
    b.order(command::jog());
    b.run(300);
    const std::int32_t released_at = b.position();
    b.order(auxiliary::release);
    b.run(20);
    CHECK(!b.status().is_enabled());
    // An encoder sees the shaft coast, an open loop does not know of it.
    CHECK((b.speed() != 0) == std::is_same_v<B, closed>);
    CHECK((b.position() != released_at) == std::is_same_v<B, closed>);
    CHECK(b.status().is_moving() == std::is_same_v<B, closed>);
    CHECK((b.status().to_word() & motion_status::released_bit) != 0);
    const std::int64_t at = b.drive.view().shaft;
    b.run(50);
    CHECK(b.drive.view().shaft > at);
    b.order(command::jog());
    b.move(100);
    b.order(command::home());
    b.run(5000);
    CHECK(!b.status().is_moving());
    CHECK(b.drive.starts() == 1);
    b.order(auxiliary::enable);
    CHECK(b.status().is_enabled());
    const std::int32_t counted = b.position();
    b.run(20);
    CHECK(b.position() == counted);
    b.move(100);
    b.run_until_still();
    CHECK(b.position() == counted + 100);
}

TEST_CASE("clear position sets zero; an absolute move counts from there, homed or not") {
    closed b;
    b.move(700);
    b.run_until_still();
    b.order(auxiliary::clear_position);
    CHECK(b.position() == 0);
    CHECK(!b.status().is_homed());
    b.move(50, positioning::absolute);
    b.run_until_still();
    CHECK(b.drive.view().shaft == 750);
}

TEST_CASE_TEMPLATE("save keeps everything that can be written; it is ignored while moving", B, BOTH) {
    B b;
    b.set(cl::positioning_speed, 111);
    b.set(cl::pair_word_order, 1);
    b.write(0x0060, {77, 1});
    b.order(command::jog());
    b.run(10);
    b.order(auxiliary::save_parameters);
    CHECK(b.drive.eeprom_writes() == 0);
    b.order(command::emergency_stop());
    b.order(auxiliary::save_parameters);
    CHECK(b.drive.saves() == 1);
    CHECK(b.drive.eeprom_writes() > 180);
    b.set(cl::positioning_speed, 222);
    b.drive.power_cycle();
    CHECK(b.get(cl::positioning_speed) == 111);
    CHECK(b.get(cl::pair_word_order) == servobus::yako::pair_order::low_first);
    CHECK(b.drive.peek(0x0060) == 77);
    CHECK(b.drive.peek(0x0061) == 1);
}

TEST_CASE("without a save a power cycle forgets; position is 0, not homed") {
    closed b;
    b.set(cl::positioning_speed, 111);
    b.set(cl::homing_method, 35);
    b.order(command::home());
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

TEST_CASE("restore brings the defaults back, at standstill only") {
    closed b;
    b.set(cl::positioning_speed, 111);
    b.order(auxiliary::save_parameters);
    b.order(command::jog());
    b.run(10);
    b.order(auxiliary::restore_parameters);
    CHECK(b.get(cl::positioning_speed) == 111);
    b.order(command::emergency_stop());
    b.order(auxiliary::restore_parameters);
    CHECK(b.get(cl::positioning_speed) == 60);
    b.drive.power_cycle();
    CHECK(b.get(cl::positioning_speed) == 60);
}

TEST_CASE("address and baud rate come with the next power-on; switches come before 0013h") {
    closed b;
    b.set(cl::node_address, 42);
    b.set(cl::rs485_baud_rate, 2);
    b.order(auxiliary::save_parameters);
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 115200);
    b.drive.power_cycle();
    CHECK(b.drive.unit() == 1);
    CHECK(b.drive.baud() == 19200);
    b.drive.set_switches(0x60); // none of the five
    CHECK(b.drive.unit() == 1);
    b.drive.power_cycle();
    CHECK(b.drive.unit() == 42);
    CHECK(b.get(cl::actual_node_address) == 42);
    CHECK(b.get(cl::dip_switches).is_on(6));
}

// Alarms, the shaft

TEST_CASE_TEMPLATE("an alarm stops and releases; it is cleared once its cause is gone", B, BOTH) {
    for (std::uint16_t code = 1; code <= 5; ++code) {
        B b;
        b.order(command::jog());
        b.run(100);
        b.drive.raise_alarm(code);
        CHECK(b.get(cl::error_code) == code);
        CHECK(b.status().has_alarm());
        CHECK(!b.status().is_enabled());
        b.order(auxiliary::enable);
        b.order(auxiliary::clear_alarm);
        CHECK(b.status().has_alarm());
        b.drive.end_alarm();
        CHECK(b.status().has_alarm());
        b.order(auxiliary::clear_alarm);
        CHECK(!b.status().has_alarm());
        CHECK(b.get(cl::error_code) == 0);
        CHECK(!b.status().is_enabled());
        b.order(auxiliary::enable);
        CHECK(b.status().is_enabled());
    }
}

TEST_CASE("an alarm whose cause persists is there again after a power cycle") {
    closed b;
    b.drive.raise_alarm(2);
    b.drive.power_cycle();
    CHECK(b.drive.alarm() == 2);
    CHECK(!b.drive.enabled());
    b.drive.end_alarm();
    b.drive.power_cycle();
    CHECK(b.drive.alarm() == 0);
    CHECK(b.drive.enabled());
}

TEST_CASE("closed loop: a blocked shaft is a following error and alarm 4") {
    closed b;
    b.set(cl::following_error_limit, 500);
    b.drive.block_shaft(true);
    b.move(400);
    b.run(100);
    CHECK(b.status().is_moving());
    CHECK(b.speed() == 0);
    b.run(2000);
    CHECK(b.position() == 0);
    CHECK(!b.status().is_moving());
    CHECK(!b.status().is_in_position());
    CHECK(!b.status().has_alarm());
    b.move(400);
    b.run(2000);
    CHECK(b.get(cl::error_code) == 4);
    b.drive.block_shaft(false);
    b.order(auxiliary::clear_alarm);
    b.order(auxiliary::enable);
    b.run(100);
    CHECK(b.status().is_in_position());
    CHECK(b.position() == 0);
}

TEST_CASE("closed loop turns a pushed shaft back, open loop does not know of it") {
    closed c;
    c.run(3000); // at rest
    c.drive.push_shaft(30);
    CHECK(c.position() == 30);
    CHECK(!c.status().is_in_position());
    c.run(100);
    CHECK(c.position() == 0);
    c.set(cl::following_error_limit, 65535);
    c.drive.push_shaft(50'000);
    c.run(3000);
    CHECK(c.position() == 0);
    c.set(cl::following_error_limit, 4000);
    c.drive.push_shaft(4500);
    c.run(1);
    CHECK(c.get(cl::error_code) == 4);

    open o;
    o.drive.push_shaft(30);
    o.run(100);
    CHECK(o.position() == 0);
    o.drive.block_shaft(true);
    o.move(500);
    o.run_until_still();
    CHECK(o.position() == 500);
    CHECK(o.drive.view().shaft == 30);
    CHECK(o.status().is_in_position());
}

// Limits

TEST_CASE_TEMPLATE("a limit stops its own direction as 0017h says", B, BOTH) {
    for (const bool coasts : {true, false}) {
        for (const int direction : {1, -1}) {
            CAPTURE(coasts);
            CAPTURE(direction);
            B b;
            b.set(cl::over_travel_stop_mode, coasts ? 0 : 1);
            b.set(cl::jog_speed, 60 * direction);
            b.order(command::jog());
            b.run(200);
            b.drive.set_input(direction > 0 ? 2 : 1, true); // the other one
            b.run(10);
            CHECK(b.status().is_moving());
            b.drive.set_input(direction > 0 ? 1 : 2, true);
            const std::int64_t at = b.drive.view().shaft;
            b.run(1);
            CHECK(b.status().is_enabled() == !coasts);
            b.run(3000);
            CHECK(!b.status().is_moving());
            CHECK((b.drive.view().shaft == at) == !coasts);
            b.order(auxiliary::enable);
            const std::int64_t rest = b.drive.view().shaft;
            b.order(command::jog());
            b.run(100);
            CHECK(b.drive.view().shaft == rest);
            b.drive.set_input(direction > 0 ? 2 : 1, false);
            b.order(auxiliary::enable);
            b.set(cl::jog_speed, -60 * direction); // away from it
            b.order(command::jog());
            b.run(100);
            CHECK(b.drive.view().shaft != rest);
        }
    }
}

TEST_CASE_TEMPLATE("software limits hold after homing", B, BOTH) {
    B b;
    b.set(cl::over_travel_stop_mode, 1);
    b.set(cl::positive_software_limit, 500);
    b.set(cl::negative_software_limit, -400);
    b.set(cl::software_limits, 1);
    b.move(1000);
    b.run_until_still();
    CHECK(b.position() == 1000);
    CHECK(!b.status().is_beyond_positive_limit());
    b.set(cl::homing_method, 35);
    b.order(command::home());
    b.run(10);
    b.move(1000);
    b.run_until_still();
    CHECK(about(b.position(), 502, 2));
    CHECK(b.status().is_beyond_positive_limit());
    b.move(10);
    b.run(100);
    CHECK(about(b.position(), 502, 2));
    b.move(-5000);
    b.run(200);
    CHECK(!b.status().is_beyond_positive_limit());
    b.run_until_still();
    CHECK(about(b.position(), -402, 2));
    CHECK(b.status().is_beyond_negative_limit());
    CHECK(b.status().is_enabled());
    b.set(cl::software_limits, 0);
    CHECK(!b.status().is_beyond_negative_limit());
}

// Homing

namespace {

enum class edge { left, right, positive_limit, negative_limit };

// Home by the summary of appendix 1 against CiA 402.
struct expected_home {
    int method; // without index; method - 16 is with index
    edge at;
    int direction;
    bool is_rising;
};
constexpr expected_home homes[] = {
    {17, edge::negative_limit, 1, false},
    {18, edge::positive_limit, -1, false},
    {19, edge::left, -1, false},
    {20, edge::left, 1, true},
    {21, edge::right, 1, false},
    {22, edge::right, -1, true},
    {23, edge::left, -1, false},
    {24, edge::left, 1, true},
    {25, edge::right, -1, true},
    {26, edge::right, 1, false},
    {27, edge::right, 1, false},
    {28, edge::right, -1, true},
    {29, edge::left, 1, true},
    {30, edge::left, -1, false},
};

sim::yako_machine machine_for(int method) {
    sim::yako_machine m = simulated::yako_slide();
    if (method == 19 || method == 20) m.home_to = sim::yako_machine::nowhere;
    if (method == 21 || method == 22) m.home_from = -sim::yako_machine::nowhere;
    return m;
}

std::int64_t place_of(const expected_home& h, const sim::yako_machine& m) {
    const int beyond = h.is_rising ? 0 : h.direction; // the first pulse at which it is inactive
    switch (h.at) {
    case edge::left: return m.home_from + beyond;
    case edge::right: return m.home_to + beyond;
    case edge::positive_limit: return m.positive_limit + beyond;
    default: return m.negative_limit + beyond;
    }
}

std::int64_t next_index(std::int64_t at, int direction, const sim::yako_machine& m) {
    do { at += direction; } while ((at - m.index) % 1000 != 0);
    return at;
}

template <class B> void stand_at(B& b, const sim::yako_machine& m, std::int64_t place) {
    b.drive.attach(m);
    b.drive.push_shaft(place);
    b.drive.power_cycle();
    REQUIRE(b.drive.view().shaft == place);
    REQUIRE(b.position() == 0);
}

template <class B> void home(B& b, int method) {
    b.set(cl::over_travel_stop_mode, 1);
    b.set(cl::homing_fast_speed, 300);
    b.set(cl::homing_slow_speed, 60);
    b.set(cl::homing_ramp_time, 50);
    b.set(cl::homing_method, method);
    b.order(command::home());
    b.run(5);
    b.run_until_still();
}

template <class B> void check_homing(int method, const expected_home& h) {
    const sim::yako_machine m = machine_for(h.method);
    for (const std::int64_t start : {-4200, -3000, -100, 240, 3100, 4200}) {
        // Methods 19..22 look on one side only.
        if ((h.method == 21 || h.method == 22 || h.method == 17) && start > m.positive_limit) continue;
        if ((h.method == 19 || h.method == 20 || h.method == 18) && start < m.negative_limit) continue;
        CAPTURE(method);
        CAPTURE(start);
        B b;
        stand_at(b, m, start);
        home(b, method);
        const std::int64_t place = place_of(h, m);
        CHECK(b.status().is_homed());
        CHECK(b.status().is_in_position());
        CHECK(b.drive.view().home == (method < 17 ? next_index(place, h.direction, m) : place));
        CHECK(b.drive.view().home_direction == h.direction);
        CHECK(b.drive.view().shaft == b.drive.view().home);
        CHECK(b.position() == 0);
    }
}

} // namespace

TEST_CASE_TEMPLATE("homing to an edge ends there, from wherever it starts", B, BOTH) {
    for (const expected_home& h : homes) check_homing<B>(h.method, h);
}

TEST_CASE("homing to an index pulse ends at the first one behind the edge") {
    for (const expected_home& h : homes) check_homing<closed>(h.method - 16, h);
}

TEST_CASE("homing to a switch narrower than the way to stop") {
    for (const expected_home& h : homes) {
        if (h.method < 23) continue;
        CAPTURE(h.method);
        for (const int start : {-3000, 3000}) {
            sim::yako_machine m = simulated::yako_slide();
            m.home_from = -5;
            m.home_to = 5;
            open b;
            stand_at(b, m, start);
            home(b, h.method);
            CHECK(b.status().is_homed());
            CHECK(b.drive.view().home == place_of(h, m));
        }
    }
}

TEST_CASE("methods 33 and 34 end at the next index pulse, 35 where it stands") {
    for (const int method : {33, 34, 35}) {
        CAPTURE(method);
        closed b;
        stand_at(b, simulated::yako_slide(), 350);
        home(b, method);
        CHECK(b.status().is_homed());
        CHECK(b.drive.view().home == (method == 33 ? 100 : method == 34 ? 1100 : 350));
        CHECK(b.position() == 0);
    }
}

TEST_CASE("collision homing runs against the stop, and back to the index pulse for -1 and -2") {
    constexpr std::int64_t wanted[] = {-4900, 4100, -5000, 5000};
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        closed b;
        sim::yako_machine m = simulated::yako_slide();
        m.negative_limit = -m.nowhere;
        m.positive_limit = m.nowhere;
        stand_at(b, m, 350);
        home(b, -1 - i);
        CHECK(b.status().is_homed());
        CHECK(!b.status().has_alarm());
        CHECK(b.drive.view().home == wanted[i]);
        CHECK(b.drive.view().shaft == wanted[i]);
    }
}

TEST_CASE("0030h: offset moves and the position afterwards, all twelve") {
    for (int mode = 0; mode < 12; ++mode) {
        CAPTURE(mode);
        constexpr std::int64_t offset = -120;
        open b;
        stand_at(b, simulated::yako_slide(), -1000);
        b.set(cl::homing_offset_mode, mode);
        b.set(cl::home_offset, offset);
        home(b, 24);
        const bool moves = mode < 6;
        const std::int64_t actual = -250 + 1000 + (moves ? offset : 0); // the counter's own
        const std::int64_t wanted[] = {offset, 0, -offset, actual, actual + offset, actual - offset};
        CHECK(b.status().is_homed());
        CHECK(b.drive.view().home == -250);
        CHECK(b.drive.view().shaft == -250 + (moves ? offset : 0));
        CHECK(b.position() == wanted[mode % 6]);
    }
}

TEST_CASE("homing takes its parameters when it is ordered") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    b.set(cl::homing_fast_speed, 60);
    b.set(cl::home_offset, 100);
    b.set(cl::homing_offset_mode, 8);
    b.order(command::home());
    b.run(300);
    b.set(cl::homing_fast_speed, 3000);
    b.set(cl::homing_method, 17);
    b.set(cl::home_offset, 200);
    b.set(cl::homing_offset_mode, 0);
    CHECK(b.speed() == 60);
    b.run_until_still();
    CHECK(b.drive.view().home == -250);
    CHECK(b.position() == -100);
}

TEST_CASE("an open loop's counter goes on through a homing that lost steps do not disturb") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    b.drive.push_shaft(77);
    b.set(cl::homing_offset_mode, 9);
    home(b, 24);
    CHECK(b.drive.view().shaft == -250);
    CHECK(b.position() == 1000 - 250 - 77);
}

TEST_CASE("homed falls when homing begins, and a stop or a limit on the wrong side leaves it so") {
    open b;
    stand_at(b, simulated::yako_slide(), -1000);
    home(b, 24);
    CHECK(b.status().is_homed());
    b.order(command::home());
    b.run(10);
    CHECK(!b.status().is_homed());
    CHECK(b.status().is_moving());
    b.order(command::stop());
    b.run_until_still();
    CHECK(!b.status().is_homed());

    open c; // method 19 looks forward only
    sim::yako_machine m = simulated::yako_slide();
    stand_at(c, m, 1000);
    home(c, 19);
    CHECK(!c.status().is_homed());
    CHECK(!c.status().is_moving());
    CHECK(c.drive.view().shaft >= m.positive_limit);
}

TEST_CASE("methods 3..6 and 19..22 that begin on the wrong side run into the limit") {
    for (const int method : {5, 6, 21, 22}) {
        closed b;
        sim::yako_machine m = simulated::yako_slide();
        stand_at(b, m, -1000);
        home(b, method);
        CHECK(!b.status().is_homed());
        CHECK(about(b.drive.view().shaft, m.negative_limit, 3));
    }
}

TEST_CASE("homing that meets both limits and no switch ends at the second") {
    open b;
    sim::yako_machine m = simulated::yako_slide();
    m.home_from = m.home_to = m.nowhere;
    stand_at(b, m, 0);
    home(b, 23);
    CHECK(!b.status().is_homed());
    CHECK(!b.status().is_moving());
    CHECK(about(b.drive.view().shaft, m.negative_limit, 3));
}

TEST_CASE("homing by a switch on a terminal that a test sets") {
    open b;
    b.set(cl::homing_method, 19);
    b.order(command::home());
    b.run(500);
    b.drive.set_input(0, true);
    b.run(1);
    b.drive.set_input(0, false); // before the motor has turned round
    b.run(500);
    CHECK(b.speed() == -60);
    b.drive.set_input(0, true);
    b.run(10);
    b.drive.set_input(0, false);
    b.run(2);
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home_direction == -1);
}

TEST_CASE("homing without its switch wired ends at the hard stop, where open loop loses steps unnoticed") {
    open b;
    sim::yako_machine m = simulated::yako_slide();
    m.home_input = m.positive_limit_input = m.negative_limit_input = m.not_wired;
    stand_at(b, m, 0);
    home(b, 24);
    CHECK(b.drive.view().shaft == 5000);
    CHECK(b.drive.view().position > 50'000);
    CHECK(b.status().is_moving());
}

TEST_CASE("normally closed switches want their polarity") {
    sim::yako_machine m = simulated::yako_slide();
    m.are_normally_closed = true;
    open b;
    stand_at(b, m, -1000);
    CHECK(b.get(ol::input_state).to_word() == 7); // all read as active
    b.set(ol::input_polarity, 7);
    CHECK(b.get(ol::input_state).to_word() == 0);
    home(b, 24);
    CHECK(b.drive.view().home == -250);
}

TEST_CASE("homing with the direction reversed needs its limits changed over") {
    sim::yako_machine m = simulated::yako_slide();
    m.positive_limit_input = 2;
    m.negative_limit_input = 1;
    open b;
    stand_at(b, m, 2000);
    b.set(cl::motion_direction, 1);
    home(b, 24); // its left edge is the machine's right one
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == 250);
    CHECK(b.drive.view().home_direction == 1);
}

// Terminals

TEST_CASE("0008h shows active inputs, four of closed loop and seven of open loop") {
    closed c;
    open o;
    for (unsigned i = 0; i < 8; ++i) {
        c.drive.set_input(i, true);
        o.drive.set_input(i, true);
    }
    CHECK(c.drive.peek(0x0008) == 0x0F);
    CHECK(o.drive.peek(0x0008) == 0x7F);
    o.set(ol::input_polarity, 0x21);
    CHECK(o.drive.peek(0x0008) == 0x5E);
}

TEST_CASE("an input frees the motor while it is active") {
    closed b;
    assign(b, 3, input_function::motor_free);
    b.order(command::jog());
    b.run(200);
    press(b, 3);
    CHECK(!b.status().is_enabled());
    b.run(3000);
    b.order(command::jog());
    b.run(20);
    CHECK(!b.status().is_moving());
    let_go(b, 3);
    CHECK(b.status().is_enabled());
    CHECK(!b.status().is_moving());

    b.order(command::jog());
    b.run(300);
    press(b, 3);
    b.order(auxiliary::release); // outlasts the input
    let_go(b, 3);
    CHECK(!b.status().is_enabled());
    CHECK(b.speed() > 0);
}

TEST_CASE("stop and emergency stop inputs stop, and hold back starts") {
    for (const input_function f : {input_function::stop, input_function::emergency_stop}) {
        closed b;
        assign(b, 3, f);
        b.set(cl::jog_deceleration_time, 500);
        b.order(command::jog());
        b.run(200);
        press(b, 3);
        CHECK(b.status().is_moving() == (f == input_function::stop));
        b.run(600);
        CHECK(!b.status().is_moving());
        CHECK(b.status().is_enabled());
        b.order(command::jog());
        b.run(20);
        CHECK(!b.status().is_moving());
        CHECK(b.drive.starts() == 1);
        let_go(b, 3);
        CHECK(!b.status().is_moving());
        b.order(command::jog());
        b.run(20);
        CHECK(b.status().is_moving());
    }
}

TEST_CASE("an input starts the position move at its edge, relative or absolute by 0050h") {
    open b;
    assign(b, 6, input_function::position_move);
    b.set(cl::target_position, 300);
    press(b, 6);
    CHECK(b.status().is_moving());
    b.run_until_still();
    CHECK(b.position() == 300);
    let_go(b, 6);
    CHECK(b.drive.starts() == 1);
    b.set(cl::io_positioning, 1);
    press(b, 6);
    b.run_until_still();
    CHECK(b.position() == 300);
    b.set(cl::io_positioning, 0);
    let_go(b, 6);
    b.order(command::jog());
    b.run(500);
    const std::int64_t at = b.drive.view().commanded;
    press(b, 6); // 5.4: a fixed length from here
    b.run_until_still();
    CHECK(about(b.drive.view().commanded, at + 300, 2));
}

TEST_CASE("speed inputs run the motor while they are active") {
    struct {
        input_function f;
        int sign;
    } const cases[] = {{input_function::speed_move, -1},
                       {input_function::jog_positive, 1},
                       {input_function::jog_negative, -1}};
    for (const auto& c : cases) {
        closed b;
        assign(b, 3, c.f);
        b.set(cl::jog_speed, -200);
        press(b, 3);
        b.run(200);
        CHECK(b.speed() == 200 * c.sign);
        let_go(b, 3);
        b.run(100);
        CHECK(!b.status().is_moving());
        b.order(auxiliary::release);
        press(b, 3);
        CHECK(!b.status().is_moving());
        b.order(auxiliary::enable); // still active: it runs
        b.run(20);
        CHECK(b.status().is_moving());
        b.order(command::stop()); // and does not start again by itself
        b.run(500);
        CHECK(!b.status().is_moving());
        CHECK(b.drive.starts() == 2);
    }
}

TEST_CASE("an input starts homing") {
    open b;
    stand_at(b, simulated::yako_slide(), 1000);
    assign(b, 4, input_function::homing);
    press(b, 4);
    b.run_until_still();
    CHECK(b.status().is_homed());
    CHECK(b.drive.view().home == -250);
}

TEST_CASE("a PT trigger starts the position segment that PIN0..PIN3 choose") {
    for (std::size_t segment = 0; segment < 16; ++segment) {
        CAPTURE(segment);
        open b;
        assign(b, 0, input_function::pt_trigger);
        for (unsigned pin = 0; pin < 4; ++pin) {
            assign(b, 3 + pin, static_cast<input_function>(14 + pin));
            b.drive.set_input(3 + pin, (segment >> pin & 1u) != 0);
        }
        const auto target = static_cast<std::int64_t>(100 + 10 * segment);
        b.set(ol::position_segment_targets[segment], target);
        b.set(ol::position_segment_speeds[segment], 90);
        b.set(ol::position_segment_acceleration_times[segment], 0);
        b.run(10);
        press(b, 0);
        CHECK(b.speed() == 90);
        b.run_until_still();
        CHECK(b.position() == target);
        b.set(ol::position_segment_positionings[segment], 1);
        let_go(b, 0);
        press(b, 0);
        b.run_until_still();
        CHECK(b.position() == target); // absolute: it is there
    }
}

TEST_CASE("a position segment of open loop begins with the start speed at 0130h + n") {
    open b;
    assign(b, 0, input_function::pt_trigger);
    b.set(ol::segment_start_speeds[0], -45);
    b.set(ol::position_segment_acceleration_times[0], 2000);
    b.run(10);
    b.drive.set_input(0, true);
    b.run(8);
    CHECK(about(b.speed(), 45, 1));
}

TEST_CASE("PIN inputs must hold from 5 ms before the trigger to 5 ms after it") {
    for (const int shift : {-6, -4, 4, 6}) { // ms of the change against the trigger
        CAPTURE(shift);
        closed b;
        assign(b, 0, input_function::pt_trigger);
        assign(b, 3, input_function::pin0);
        b.run(30);
        if (shift < 0) {
            b.drive.set_input(3, true);
            b.run(static_cast<std::uint32_t>(-shift));
        }
        b.drive.set_input(0, true);
        b.run(static_cast<std::uint32_t>(shift > 0 ? shift : 1));
        if (shift > 0) b.drive.set_input(3, true);
        b.run(20);
        CHECK(b.status().is_moving() == (std::abs(shift) == 6));
    }
}

TEST_CASE("a PV trigger runs a speed segment while it is active, and changes it with the PIN inputs") {
    closed b;
    assign(b, 0, input_function::pv_trigger);
    assign(b, 3, input_function::pin0);
    b.set(cl::speed_segment_speeds[0], 60);
    b.set(cl::speed_segment_speeds[1], -90);
    b.run(10);
    press(b, 0);
    b.run(100);
    CHECK(b.speed() == 60);
    press(b, 3);
    b.run(300);
    CHECK(b.speed() == -90);
    let_go(b, 0);
    b.run(200);
    CHECK(!b.status().is_moving());
}

TEST_CASE("with 0051h = 1 a PV edge starts a speed segment, and PT may interrupt it") {
    closed b;
    assign(b, 0, input_function::pv_trigger);
    assign(b, 1, input_function::pt_trigger);
    assign(b, 2, input_function::speed_segment_direction);
    b.set(cl::pv_trigger_mode, 1);
    b.set(cl::position_segment_targets[0], 500);
    b.drive.set_input(2, true);
    b.run(10);
    press(b, 0);
    let_go(b, 0);
    b.run(200);
    CHECK(b.speed() == -100);
    const std::int64_t at = b.drive.view().commanded;
    press(b, 1);
    b.run_until_still();
    CHECK(about(b.drive.view().commanded, at + 500, 15));
    CHECK(!b.status().is_moving());
}

TEST_CASE("outputs show their function, and 004Bh turns their level") {
    open b;
    const auto is_on = [&](output_function f) {
        b.set(ol::y2_function, f);
        CHECK(b.drive.output(2) == (b.drive.peek(0x0009) == 4));
        return b.drive.output(2);
    };
    using enum output_function;
    CHECK(is_on(brake));
    CHECK(!is_on(alarm));
    CHECK(!is_on(driver_status));
    CHECK(!is_on(homing_complete));
    CHECK(!is_on(undefined));
    b.run(20);
    CHECK(is_on(in_position));
    b.set(ol::user_outputs, 5);
    CHECK(is_on(user_0));
    CHECK(!is_on(user_1));
    CHECK(is_on(user_2));
    b.order(command::jog());
    b.run(10);
    CHECK(is_on(driver_status));
    CHECK(!is_on(in_position));
    b.order(command::emergency_stop());
    b.set(ol::homing_method, 35);
    b.order(command::home());
    b.run(10);
    CHECK(is_on(homing_complete));
    b.drive.raise_alarm(3);
    CHECK(is_on(alarm));
    CHECK(!is_on(brake));
    b.set(ol::output_polarity, 7);
    b.set(ol::y2_function, alarm);
    CHECK(!b.drive.output(2));
    CHECK(b.drive.output(0));
    CHECK(b.drive.peek(0x0009) == 4);
    CHECK(!b.drive.output(3));
}

// Time, line

TEST_CASE("nothing depends on how often the clock is looked at") {
    closed fine;
    closed coarse;
    for (closed* b : {&fine, &coarse}) {
        b->run(3000);
        b->move(20'000);
    }
    for (int i = 0; i < 4000; ++i) fine.run_us(250);
    coarse.run_us(1'000'000);
    CHECK(fine.drive.view().position == coarse.drive.view().position);
    CHECK(fine.drive.view().speed == coarse.drive.view().speed);
    CHECK(fine.status() == coarse.status());
}

TEST_CASE("long moves at every resolution end exactly") {
    for (const int pulses : {400, 1000, 51200}) {
        for (const int speed : {1, 60, 3000}) {
            for (const int time : {0, 1, 2000}) {
                CAPTURE(pulses);
                CAPTURE(speed);
                CAPTURE(time);
                open b;
                b.set(cl::microstep_resolution, pulses);
                b.set(cl::positioning_speed, speed);
                b.set(cl::acceleration_time, time);
                b.set(cl::deceleration_time, time);
                const std::int64_t target = std::int64_t{pulses} * speed / 15 + 7; // four seconds
                b.move(-target);
                const std::uint32_t took = b.run_until_still();
                CHECK(took < 4000 + 2000 + 1000);
                CHECK(b.position() == -target);
            }
        }
    }
}

TEST_CASE("a client on a line reads and writes the drive, and learns its word order") {
    simulated::yako_closed_loop_rig rig;
    client<simulated::yako_closed_loop_rig::line_type, cl::device> c{rig.line, node<cl::device>{1}};
    CHECK(!c.read<cl::actual_position>());
    REQUIRE(c.learn_word_order() == failure{});
    REQUIRE(c.write<cl::target_position>(checked(2500)));
    REQUIRE(c.write<cl::motion_command>(command::move(positioning::absolute)));
    rig.run(5000);
    const auto at = c.read<cl::actual_position>();
    REQUIRE(at);
    CHECK(at->count() == 2500);
    CHECK(rig.sent(hex("01 06 00 27 00 05 F9 C2")) == 1);
    CHECK(rig.model.view().position == 2500);
}
