// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades against their simulators, on a line without faults: init, enable and release, alarms,
// terminals, limits, word order and speed resolution, saving, and values that are out of range.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace drive_yako_settings_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::enable_frame;
using enabled_yako::gentle;
using enabled_yako::stop_frame;
using enabled_yako::whole_rpm;
using enabled_yako::state_checked::take;
using enabled_yako::state_checked::take_homed;
using simulated::closed_axis;
using simulated::open_axis;
using simulated::writes_to;

namespace {

constexpr auto release_frame = hex("01 06 00 2D 00 11 D9 CF");

} // namespace

TEST_CASE("5.1: during an alarm moves and enable are refused; a reset clears it once its cause is gone") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.run(300);
    a.model.raise_alarm(2);
    const auto f = a.drive.read();
    REQUIRE(f);
    CHECK(f->has_fault());
    CHECK(f->error == 2);
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).error() == errc::faulted);
    CHECK(a.drive.run(enable{}).error() == errc::faulted);
    a.run(3000);
    CHECK(a.drive.run(fault_reset{}).error() == errc::faulted);
    a.model.end_alarm();
    REQUIRE(a.drive.run(fault_reset{}));
    CHECK(a.sent(hex("01 06 00 2D 00 21 D9 DB")) == 2);
    CHECK(a.drive.state() == drive_state::disabled);
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).error() == errc::wrong_state);
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(move_by{1 * pulse, brisk}));
}

TEST_CASE("5.1: enable and release send the manual's frames; a release first stops the motor") {
    closed_axis a{{.is_enabled_at_power_on = false}};
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.state() == drive_state::disabled);
    CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::wrong_state);
    REQUIRE(a.drive.run(enable{}));
    CHECK(a.sent(enable_frame) == 1);
    REQUIRE(a.drive.run(velocity{300 * r_per_min}));
    a.run(500);
    REQUIRE(a.drive.run(disable{}));
    CHECK(a.sent(release_frame) == 1);
    CHECK_FALSE(a.is_moving());
    CHECK_FALSE(a.model.enabled());
    CHECK(a.drive.state() == drive_state::disabled);
}

TEST_CASE("5.2: terminal functions are set only while released; polarity and user outputs are set") {
    open_axis a;
    take(a);
    CHECK(a.drive.run(set_input{input_terminal::x4, input_function::home}).error() == errc::wrong_state);
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x6, input_function::stop}));
    CHECK(a.model.peek(0x0047) == 5);
    REQUIRE(a.drive.run(open_loop::set_input_polarity{{.x2 = true, .x6 = true}}));
    CHECK(a.model.peek(0x0040) == 0x44);
    REQUIRE(a.drive.run(set_output{output_terminal::y2, output_function::user_2}));
    REQUIRE(a.drive.run(open_loop::set_output_polarity{{.y0 = true}}));
    REQUIRE(a.drive.run(open_loop::set_outputs{{.y2 = true}}));
    CHECK(a.model.output(2));
    const auto f = a.drive.read();
    REQUIRE(f);
    CHECK(f->outputs.y2);
    CHECK(f->inputs.x6); // normally closed, and open
    const auto frames = a.requests.size();
    CHECK(a.drive.run(set_output{output_terminal::y0, static_cast<output_function>(7)}).error() ==
          errc::out_of_range);
    CHECK(a.drive.run(set_output{output_terminal::y0, static_cast<output_function>(12)}).error() ==
          errc::out_of_range);
    CHECK(a.drive.run(set_input{input_terminal::x0, static_cast<input_function>(19)}).error() ==
          errc::out_of_range);
    CHECK(a.requests.size() == frames);
    closed_axis c;
    REQUIRE(c.drive.run(init{}));
    CHECK(c.drive.run(set_input{input_terminal::x4, input_function::home}).error() == errc::bad_argument);
    CHECK(c.drive.run(set_output{output_terminal::y2, output_function::alarm}).error() == errc::bad_argument);
}

TEST_CASE("5.3: both software limits are set in one frame before they are switched on, and act once homed") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(set_over_travel_stop{over_travel_stop::emergency_stop}));
    REQUIRE(a.drive.run(limit_travel{-2000 * pulse, 2000 * pulse}));
    CHECK(a.sent(modbus::write_frame(1, 0x0037, std::array<u16, 4>{0, 2000, 0xFFFF, 0xF830})) == 1);
    CHECK(a.model.peek(0x0018) == 1);
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.run(move_by{9000 * pulse, brisk}));
    CHECK(a.drive.run(wait_standstill{}).error() == errc::stopped_short);
    CHECK(a.place() < 2100);
    CHECK(a.drive.read()->state.is_beyond_positive_limit());
    REQUIRE(a.drive.run(unlimit_travel{}));
    CHECK(a.model.peek(0x0018) == 0);
    CHECK(a.drive.run(limit_travel{0 * pulse, 0 * pulse}).error() == errc::bad_argument);
}

TEST_CASE("5.5, G22: 32-bit values have the drive's word order, whichever it is") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
    CHECK(a.drive.cached().word_order == word_order::low_first);
    REQUIRE(a.drive.run(move_by{70'000 * pulse, brisk}));
    CHECK(a.sent(modbus::write_frame(1, 0x0020, std::array<u16, 6>{10, 50, 50, 600, 0x1170, 1})) == 1);
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 70'000);
    REQUIRE(a.drive.read());
    CHECK(a.drive.feedback(milliseconds(2000))->position == 70'000 * pulse);
    closed_loop::drive<closed_axis::line_type> successor{a.line, 1};
    REQUIRE(successor.run(init{}));
    CHECK(successor.cached().word_order == word_order::low_first);
    REQUIRE(successor.run(move_by{-70'000 * pulse, brisk}));
    REQUIRE(successor.run(wait_standstill{}));
    CHECK(a.place() == 0);
}

TEST_CASE("A37: 0.1 r/min is used only after the program has requested it, and stored speeds must then be "
          "set again") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
    REQUIRE(a.drive.run(velocity{125 * part<10>(r_per_min)}));
    CHECK(a.model.peek(0x001D) == 125);
    a.run(500);
    CHECK(a.drive.read()->speed == 125 * part<10>(r_per_min));
    REQUIRE(a.drive.run(halt{}));
    CHECK(a.drive.run(move_by{10 * pulse}).error() == errc::wrong_state);
    CHECK(a.drive.run(closed_loop::home{homing::home_24}).error() == errc::wrong_state);
    REQUIRE(a.drive.run(set_profile{gentle}));
    CHECK(a.model.peek(0x0023) == 600);
    REQUIRE(a.drive.run(move_by{10 * pulse}));
    REQUIRE(a.drive.run(wait_standstill{}));

    closed_loop::drive<closed_axis::line_type> successor{a.line, 1};
    REQUIRE(successor.run(init{}));
    CHECK(successor.cached().resolution == speed_count::tenth_r_per_min);
    const auto frames = a.requests.size();
    CHECK(successor.run(velocity{60 * r_per_min}).error() == errc::wrong_state);
    CHECK(successor.run(move_by{10 * pulse, brisk}).error() == errc::wrong_state);
    CHECK(successor.run(move_by{10 * pulse}).error() == errc::wrong_state);
    CHECK(successor.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}).error() == errc::wrong_state);
    CHECK(a.requests.size() == frames);
    REQUIRE(successor.run(set_speed_resolution{speed_count::one_r_per_min}));
    CHECK(successor.run(move_by{10 * pulse}).error() == errc::wrong_state); // 600 counts were 60 r/min
    REQUIRE(successor.run(velocity{60 * r_per_min}));
    a.run(500);
    CHECK(whole_rpm(a.model.view().speed) == 60);
    open_axis o;
    take(o);
    CHECK(o.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}).error() == errc::bad_argument);
}

TEST_CASE("save and factory_reset work only at standstill and are sent once; a factory reset requires init") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(save{}));
    CHECK(a.sent(hex("01 06 00 2D 00 42 99 F2")) == 1);
    CHECK(a.model.saves() == 1);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    CHECK(a.drive.run(save{}).error() == errc::busy);
    CHECK(a.drive.run(factory_reset{sole_drive_on_the_line{}}).error() == errc::busy);
    CHECK(a.model.saves() == 1);
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
    REQUIRE(a.drive.run(factory_reset{sole_drive_on_the_line{}}));
    CHECK(a.sent(hex("01 06 00 2D 00 41 D9 F3")) == 1);
    CHECK(a.model.peek(0x0019) == 0);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.drive.run(velocity{60 * r_per_min}).error() == errc::needs_init);
}

TEST_CASE("2: address, baud rate and format are set, and values out of range are refused") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(set_baud_rate{baud_rate::baud_38400}));
    CHECK(a.model.peek(0x0014) == 1);
    REQUIRE(a.drive.run(set_serial_format{serial_format::e81}));
    CHECK(a.model.peek(0x0015) == 2);
    CHECK(a.drive.run(set_baud_rate{static_cast<baud_rate>(4)}).error() == errc::out_of_range);
    CHECK(a.drive.run(set_node_address{0, sole_drive_on_the_line{}}).error() == errc::out_of_range);
    CHECK(a.drive.run(set_node_address{248, sole_drive_on_the_line{}}).error() == errc::out_of_range);
    REQUIRE(a.drive.run(set_node_address{7, sole_drive_on_the_line{}}));
    CHECK(a.model.peek(0x0013) == 7);
    CHECK(a.drive.state() == drive_state::needs_init);
}

TEST_CASE("feedback is one read of 0006h..000Ch") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{-1234 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    a.model.set_input(3, true);
    a.run(50);
    a.requests.clear();
    const auto f = a.drive.read();
    REQUIRE(f);
    CHECK(a.requests.size() == 1);
    CHECK(a.sent(modbus::read_frame(1, 0x0006, 7)) == 1);
    CHECK(f->position == -1234 * pulse);
    CHECK(f->speed == 0 * r_per_min);
    CHECK(f->state.is_in_position());
    CHECK(f->state.is_enabled());
    CHECK_FALSE(f->has_fault());
    CHECK(f->inputs.x3);
    CHECK_FALSE(f->inputs.x0);
}

TEST_CASE("S1: init stops the motion that a crashed program left, and neither moves nor enables the drive") {
    for (const int what : {0, 1, 2}) {
        closed_axis a;
        a.model.attach(simulated::yako_slide());
        take(a);
        if (what == 0) REQUIRE(a.drive.run(velocity{100 * r_per_min}));
        if (what == 1) REQUIRE(a.drive.run(move_by{3000 * pulse, gentle}));
        if (what == 2) REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
        while (!a.is_moving()) a.turn();
        servobus::line restarted{a.wire, modbus::timing_at(115200)};
        a.run(20);
        a.requests.clear();
        closed_loop::drive successor{restarted, 1};
        REQUIRE(successor.run(init{}));
        CHECK(same_bytes(a.requests[0], stop_frame));
        for (std::size_t i = 1; i < a.requests.size(); ++i)
            CHECK((a.requests[i][1] == 0x03 || simulated::is_marker(a.requests[i])));
        CHECK_FALSE(a.is_moving());
        CHECK(successor.cached().microsteps == 1000);
        CHECK_FALSE(successor.cached().is_homed);
    }
}

TEST_CASE("before init only stops are sent, and with an invalid node address nothing") {
    closed_axis a;
    CHECK(a.drive.run(enable{}).error() == errc::needs_init);
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.drive.run(velocity{1 * r_per_min}).error() == errc::needs_init);
    CHECK(a.drive.run(closed_loop::home{homing::home_24}).error() == errc::needs_init);
    CHECK(a.drive.run(save{}).error() == errc::needs_init);
    CHECK(a.drive.run(set_word_order{word_order_setting::high_first}).error() == errc::needs_init);
    CHECK(a.drive.run(limit_travel{0 * pulse, 1 * pulse}).error() == errc::needs_init);
    CHECK(a.drive.read().error() == errc::needs_init);
    for (const unsigned address : {0u, 248u, 255u}) {
        closed_loop::drive<closed_axis::line_type> nobody{a.line, static_cast<std::uint8_t>(address)};
        CHECK(nobody.run(init{}).error() == errc::bad_argument);
    }
    CHECK(a.requests.empty());
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(quick_stop{}));
    REQUIRE(a.drive.run(disable{}));
    CHECK(a.drive.state() == drive_state::needs_init);
}

TEST_CASE("values outside their range are refused before anything is sent") {
    closed_axis a;
    take_homed(a);
    const auto frames = a.requests.size();
    const auto with = [](speed top, yako::time ramp) {
        return motion_profile{0 * r_per_min, ramp, ramp, top};
    };
    CHECK(a.drive.run(move_by{1 * pulse, with(3001 * r_per_min, {})}).error() == errc::out_of_range);
    CHECK(a.drive.run(move_by{1 * pulse, with(-1 * r_per_min, {})}).error() == errc::out_of_range);
    CHECK(a.drive.run(move_by{1 * pulse, with(15 * part<10>(r_per_min), {})}).error() == errc::inexact);
    CHECK(a.drive.run(move_by{1 * pulse, with(1 * r_per_min, 2001 * millisecond)}).error() ==
          errc::out_of_range);
    CHECK(a.drive.run(move_by{1 * pulse, with(1 * r_per_min, -1 * millisecond)}).error() ==
          errc::out_of_range);
    CHECK(a.drive.run(move_by{3'000'000'000 * pulse, brisk}).error() == errc::out_of_range);
    CHECK(a.drive.run(move_to{-3'000'000'000 * pulse, brisk}).error() == errc::out_of_range);
    CHECK(a.drive.run(set_homing_profile{4 * r_per_min, 5 * r_per_min}).error() == errc::out_of_range);
    CHECK(a.drive.run(set_homing_profile{60 * r_per_min, 301 * r_per_min}).error() == errc::out_of_range);
    CHECK(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min, 29 * millisecond}).error() ==
          errc::out_of_range);
    CHECK(a.drive.run(set_profile{{}}).error() == errc::bad_argument);
    CHECK(a.drive.run(set_position_segment{1, 1 * pulse, 1 * r_per_min, {}, {}, static_cast<positioning>(2)})
              .error() == errc::out_of_range);
    CHECK(a.requests.size() == frames);
}

TEST_CASE("G20: a superloop that never waits controls the axis; the axis stops after the command timeout") {
    closed_axis a;
    const auto turn = [&] {
        const std::uint64_t before = a.wire.time_us();
        (void)a.drive.step();
        CHECK(a.wire.time_us() - before < 100); // no step waits
        a.wire.pass(microseconds(50));
    };
    const auto finish = [&] {
        while (!a.drive.is_idle()) turn();
        REQUIRE(a.drive.last());
    };
    REQUIRE(a.drive.begin(init{}) == errc::ok);
    finish();
    REQUIRE(a.drive.begin(enable{}) == errc::ok);
    CHECK(a.drive.begin(enable{}) == errc::busy);
    finish();
    a.drive.set_command_timeout(milliseconds(400));
    REQUIRE(a.drive.begin(velocity{60 * r_per_min}) == errc::ok);
    finish();
    const auto stops = a.sent(stop_frame);
    for (int i = 0; i < 4000; ++i) turn();
    CHECK(a.is_moving());
    for (int i = 0; i < 20'000; ++i) turn();
    CHECK(a.sent(stop_frame) == stops + 1);
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("each word of a segment is read back: one that the drive does not hold ends the command") {
    const auto check = [](const auto& wanted, u16 first, u16 count) {
        for (u16 i = 0; i < count; ++i) {
            const auto address = static_cast<u16>(first + i);
            CAPTURE(address);
            closed_axis a;
            take(a);
            REQUIRE(a.drive.begin(wanted) == errc::ok);
            for (tests::loop_bound left{"the write of the segment"}; !writes_to(a.requests.back(), address);
                 left.use())
                a.turn();
            std::vector<std::uint8_t> held; // another program writes
            for (u16 at = first; at < first + count; ++at) {
                const unsigned word = a.model.peek(at) ^ (at == address ? 1u : 0u);
                held.push_back(static_cast<std::uint8_t>(word >> 8));
                held.push_back(static_cast<std::uint8_t>(word & 0xFFu));
            }
            REQUIRE(a.model.write(first, words_view{held}) == 0);
            a.finish();
            CHECK(a.drive.last().error() == errc::unexpected_value);
        }
    };
    check(set_position_segment{2, 70'000 * pulse, 90 * r_per_min}, 0x0066, 6);
    check(set_speed_segment{2, 90 * r_per_min}, 0x00C3, 3);
}

TEST_CASE("5.3: limits that were set are known, until they are switched off") {
    closed_axis a;
    take(a);
    CHECK(a.drive.cached().limits == limit_enable::disabled);
    REQUIRE(a.drive.run(limit_travel{-2000 * pulse, 2000 * pulse}));
    CHECK(a.drive.cached().limits == limit_enable::after_homing);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.cached().limits == limit_enable::after_homing); // as the drive says
    REQUIRE(a.drive.run(unlimit_travel{}));
    CHECK(a.drive.cached().limits == limit_enable::disabled);
}

} // namespace drive_yako_settings_tests
