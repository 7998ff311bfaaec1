// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades with a drive that acknowledges a command without executing it, refuses it, restarts or
// raises an alarm, and with a program that crashes; and what they check before the next motion.
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace drive_yako_faults_drive_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::gentle;
using enabled_yako::save_frame;
using enabled_yako::start_homing_frame;
using enabled_yako::start_jog_frame;
using enabled_yako::start_relative_frame;
using enabled_yako::stop_frame;
using enabled_yako::take;
using enabled_yako::take_homed;
using simulated::closed_axis;
using simulated::open_axis;
using simulated::writes_to;

namespace {

bool is_32_bit_write(bytes f) {
    for (const u16 pair : std::initializer_list<u16>{0x24, 0x35, 0x37, 0x39, 0x60}) {
        if (writes_to(f, pair)) return true;
    }
    return false;
}
bool is_speed_write(bytes f) {
    for (const u16 at : std::initializer_list<u16>{0x1D, 0x20, 0x23, 0x32, 0x33, 0x62, 0xC0}) {
        if (writes_to(f, at)) return true;
    }
    return false;
}

} // namespace

TEST_CASE("S4: a start of any kind that is acknowledged and not executed is reported") {
    closed_axis a{{.start_delay = milliseconds(3000)}};
    take(a);
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    const auto check = [&](const command_status& r) {
        CHECK(r.error() == errc::not_executed);
        CHECK(a.drive.motion() == motion_check::not_seen);
        CHECK(a.drive.state() == drive_state::enabled); // the rest of the cached state is valid
        REQUIRE(a.drive.run(halt{}));
    };
    const std::uint64_t start = a.wire.time_us();
    check(a.drive.run(move_by{1000 * pulse, brisk}));
    CHECK(a.wire.time_us() - start > 200'000);
    CHECK(a.wire.time_us() - start < 300'000);
    check(a.drive.run(velocity{60 * r_per_min}));
    check(a.drive.run(bounded_jog{1000 * pulse, brisk}));
    check(a.drive.run(closed_loop::home{homing::home_24}));
    CHECK(a.sent(start_relative_frame) == 2);
    CHECK(a.sent(start_jog_frame) == 1);
    CHECK(a.sent(start_homing_frame) == 1);
    CHECK(a.place() == 0);
}

TEST_CASE("S4: a homing that is not executed is none, though the axis is homed and stands at its home") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::stop}));
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
    for (const bool has_homed : {false, true}) {
        CAPTURE(has_homed);
        a.model.set_input(3, !has_homed); // the drive ignores starts
        a.run(10);
        if (has_homed) {
            REQUIRE(a.drive.run(closed_loop::home{homing::home_24}));
            a.model.set_input(3, true);
            a.run(10);
        }
        CHECK(a.drive.run(closed_loop::home{homing::home_24}).error() == errc::not_executed);
        CHECK(a.drive.motion() == motion_check::not_seen);
    }
}

TEST_CASE("S4: the profile of a move that was not executed is the one that the drive holds") {
    closed_axis a{{.start_delay = milliseconds(3000)}};
    take(a);
    REQUIRE(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::not_executed);
    REQUIRE(a.drive.run(halt{}));
    CHECK(a.drive.run(move_by{1000 * pulse}).error() == errc::not_executed); // by that profile
    CHECK(a.drive.state() == drive_state::enabled);
}

TEST_CASE("S4: a move that the drive ignores because a stop input is active is reported as not executed") {
    closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(disable{}));
    REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::stop}));
    REQUIRE(a.drive.run(enable{}));
    a.model.set_input(3, true);
    a.run(10);
    CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::not_executed);
    CHECK(a.drive.run(move_by{1000 * pulse, brisk}).outcome() == outcome::unknown);
    a.model.set_input(3, false);
    a.run(10);
    REQUIRE(a.drive.run(move_by{1000 * pulse, brisk}));
}

TEST_CASE("S4: a save or factory reset that the drive acknowledges and ignores, because an input moves the "
          "motor, is reported") {
    for (const bool is_reset : {false, true}) {
        closed_axis a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(disable{}));
        REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::jog_positive}));
        REQUIRE(a.drive.run(enable{}));
        const std::uint32_t before = a.wire.requests();
        if (is_reset) {
            REQUIRE(a.drive.begin(factory_reset{sole_drive_on_the_line{}}) == errc::ok);
        } else {
            REQUIRE(a.drive.begin(save{}) == errc::ok);
        }
        while (a.wire.requests() < before + 2) a.turn(); // the status was read
        a.model.set_input(3, true);
        a.run(5);
        REQUIRE(a.is_moving());
        a.finish();
        CHECK(a.drive.last().error() == errc::not_executed);
        CHECK(a.model.saves() == 0);
        CHECK(a.drive.state() == drive_state::enabled);
        CHECK(a.sent(save_frame) == (is_reset ? 0 : 1));
        CHECK(a.model.peek(0x0044) == 9); // nothing was reset
    }
}

TEST_CASE("S6, A37: a restarted drive gets no position in the wrong word order and no speed in the wrong "
          "resolution") {
    SUBCASE("the word order was reset") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_word_order{word_order_setting::low_first}));
        a.model.power_cycle();
        a.requests.clear();
        CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
        for (const auto& f : a.requests) CHECK_FALSE(is_32_bit_write(f));
    }
    SUBCASE("the speed resolution was reset") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        a.model.power_cycle();
        a.requests.clear();
        CHECK(a.drive.run(velocity{60 * r_per_min}).error() == errc::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{100 * pulse, brisk}).error() == errc::needs_init);
        for (const auto& f : a.requests) CHECK_FALSE(is_speed_write(f));
    }
    SUBCASE("the homing was lost: a move, a read and a setting detect it") {
        for (const int how : {0, 1, 2}) {
            closed_axis a;
            take_homed(a);
            a.model.power_cycle();
            if (how == 0) CHECK(a.drive.run(move_to{500 * pulse, brisk}).error() == errc::needs_init);
            if (how == 1) REQUIRE(a.drive.read());
            if (how == 2) CHECK(a.drive.run(set_profile{brisk}).error() == errc::needs_init);
            CHECK(a.drive.state() == drive_state::needs_init);
            CHECK(a.place() == 0);
            CHECK(a.model.starts() == 1); // the declaration
        }
    }
    SUBCASE("the stored profile and the homing speeds were reset") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(set_profile{brisk}));
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{500 * pulse}).error() == errc::needs_init);
        CHECK(a.drive.state() == drive_state::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(move_by{500 * pulse, brisk}));
        REQUIRE(a.drive.run(wait_standstill{}));
        const std::uint32_t starts = a.model.starts();
        a.model.power_cycle();
        CHECK(a.drive.run(bounded_jog{500 * pulse}).error() == errc::needs_init);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(set_homing_profile{20 * r_per_min, 10 * r_per_min}));
        a.model.power_cycle();
        CHECK(a.drive.run(closed_loop::home{homing::home_24}).error() == errc::needs_init);
        CHECK(a.model.starts() == starts);
    }
    SUBCASE("the motor is released after the restart") {
        closed_axis a{{.is_enabled_at_power_on = false}};
        take(a);
        a.model.power_cycle();
        CHECK(a.drive.run(move_by{500 * pulse, brisk}).error() == errc::needs_init);
        CHECK(a.drive.state() == drive_state::needs_init);
        CHECK(a.model.starts() == 0);
    }
}

TEST_CASE("G16: a command that the drive refuses by an exception was not done, and the cached state stays "
          "valid") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
    // The model enforces the range of its words. The manual does not state whether a drive does.
    const command_status r = a.drive.run(velocity{3000 * r_per_min});
    CHECK(r.outcome() == outcome::refused);
    CHECK(r.exception() == 7);
    CHECK(a.drive.state() == drive_state::enabled);
    CHECK(a.drive.cached().is_homed);
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("an alarm while the axis homes or has just begun to move ends the command") {
    closed_axis a;
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!a.is_moving()) a.turn();
    for (int i = 0; i < 20; ++i) a.turn();
    a.model.raise_alarm(1);
    a.finish();
    CHECK(a.drive.last().error() == errc::faulted);
    CHECK_FALSE(a.drive.cached().is_homed);
    a.model.end_alarm();
    a.run(2000);
    REQUIRE(a.drive.run(fault_reset{}));
    REQUIRE(a.drive.run(enable{}));
    a.model.block_shaft(true); // closed loop: the motion begins, then the drive detects the blocked shaft
    (void)a.drive.run(move_by{40'000 * pulse, brisk});
    CHECK(a.drive.run(wait_standstill{}).error() == errc::faulted);
}

TEST_CASE("S1: whatever a program was doing when it crashed, init of the next program first stops the axis") {
    for (std::size_t crash = 0; crash < 60; ++crash) {
        open_axis a;
        a.model.attach(simulated::yako_slide());
        std::size_t left = crash;
        const auto run_until_crash = [&](const auto& wanted) {
            if (left == 0 || a.drive.begin(wanted) != errc::ok) return;
            const std::size_t before = a.requests.size();
            while (!a.drive.is_idle() && a.requests.size() - before < left) a.turn();
            const std::size_t used = a.requests.size() - before;
            left = used >= left ? 0 : left - used;
        };
        run_until_crash(init{});
        run_until_crash(enable{});
        run_until_crash(open_loop::home{homing::home_24});
        run_until_crash(move_to{300 * pulse, gentle});
        a.run(crash % 2 == 0 ? 20 : 400);
        servobus::line restarted{a.wire, modbus::timing_at(115200)};
        a.run(150);
        a.requests.clear();
        open_loop::drive successor{restarted, 1};
        REQUIRE(successor.run(init{}));
        CHECK_FALSE(a.is_moving());
        REQUIRE_FALSE(a.requests.empty());
        CHECK(same_bytes(a.requests[0], stop_frame));
        for (std::size_t i = 1; i < a.requests.size(); ++i)
            CHECK((a.requests[i][1] == 0x03 || simulated::is_marker(a.requests[i])));
        CHECK(successor.run(move_to{0 * pulse, gentle}).error() == errc::needs_homing);
    }
}

TEST_CASE("S4: an earlier homing is not accepted after an event that may have lost the position") {
    SUBCASE("a quick stop") {
        closed_axis a;
        take_homed(a);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(velocity{60 * r_per_min}));
        REQUIRE(a.drive.run(quick_stop{}));
        CHECK(a.drive.run(accept_position{}).error() == errc::needs_homing);
        CHECK(a.drive.run(move_to{500 * pulse}).error() == errc::needs_homing);
    }
    SUBCASE("an open loop drive that was released") {
        open_axis a;
        take_homed(a);
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(disable{}));
        REQUIRE(a.drive.run(enable{}));
        CHECK(a.drive.run(accept_position{}).error() == errc::needs_homing);
    }
}

TEST_CASE("4.1: a jog is not interrupted by a move, which acts in positioning only") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    const std::size_t before = a.sent(start_relative_frame);
    CHECK(a.drive.run(relative_move{.way = 100 * pulse, .then = while_moving::interrupt}).error() ==
          errc::busy);
    CHECK(a.sent(start_relative_frame) == before);
    REQUIRE(a.drive.run(halt{}));
    REQUIRE(a.drive.run(move_by{50'000 * pulse, gentle}));
    CHECK(a.drive.motion() == motion_check::seen);
    REQUIRE(a.drive.run(relative_move{.way = -100 * pulse, .then = while_moving::interrupt}));
    CHECK(a.drive.motion() == motion_check::unknown); // it cannot be seen which of the two moves runs
}

TEST_CASE("limits are set only at standstill, and a cleared position is read back") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(move_by{5000 * pulse, gentle}));
    CHECK(a.drive.run(limit_travel{-100 * pulse, 100 * pulse}).error() == errc::busy);
    REQUIRE(a.drive.run(wait_standstill{}));
    REQUIRE(a.drive.run(clear_position{}));
    CHECK(a.drive.feedback(milliseconds(2000))->position.count() == 0);
}

TEST_CASE("A54: a cleared position leaves an axis homed only where the drive says so") {
    for (const auto homed : {sim::yako_homed::until_homing, sim::yako_homed::until_place_lost}) {
        closed_axis a{{.homed = homed}};
        take_homed(a);
        REQUIRE(a.drive.run(move_by{500 * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
        CHECK(a.drive.run(clear_position{}));
        const command_status next = a.drive.run(move_to{100 * pulse, brisk});
        CHECK(next.error() == (homed == sim::yako_homed::until_homing ? errc::ok : errc::needs_homing));
        CHECK(a.drive.state() == drive_state::enabled);
    }
}

TEST_CASE("a bounded jog that runs does not confirm one in the other direction") {
    for (const int sign : {1, -1}) {
        CAPTURE(sign);
        closed_axis a;
        take_homed(a);
        const std::uint32_t before = a.model.starts();
        REQUIRE(a.drive.run(bounded_jog{2000 * sign * pulse}));
        CHECK(a.drive.run(bounded_jog{-2000 * sign * pulse}).error() == errc::busy);
        CHECK(a.drive.run(hold{-60 * sign * r_per_min, milliseconds(50)}).error() == errc::busy);
        CHECK(a.drive.run(bounded_jog{2000 * sign * pulse}));
        CHECK(a.model.starts() == before + 1);
    }
}

TEST_CASE("S4: the next command detects that a restart lost the software limits, also without a homing") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(limit_travel{-5000 * pulse, 5000 * pulse}));
    REQUIRE(a.drive.run(move_by{10 * pulse, brisk}));
    a.model.power_cycle();
    CHECK(a.drive.run(move_by{10 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.model.starts() == 1);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.cached().limits == limit_enable::disabled);
    REQUIRE(a.drive.run(move_by{10 * pulse, brisk}));
}

TEST_CASE("G35: an alarm that was read stays in the state for hours, also where nothing is read after it") {
    simulated::closed_axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    a.model.raise_alarm(1);
    CHECK(a.drive.read());
    CHECK(a.drive.state() == drive_state::faulted);
    for (int minutes = 0; minutes < 200; ++minutes) {
        CAPTURE(minutes);
        for (int i = 0; i < 60; ++i) {
            (void)a.drive.step();
            a.wire.pass(milliseconds(1000));
        }
        REQUIRE(a.drive.state() == drive_state::faulted);
        if (minutes > 30) CHECK(a.drive.feedback(milliseconds(1'800'000)).error() == errc::timeout);
    }
}

TEST_CASE("S4: whether a start that got no response was carried out is not known, whatever it starts") {
    for (const bool is_homing : {false, true}) {
        CAPTURE(is_homing);
        closed_axis a;
        a.model.attach(simulated::yako_slide());
        take_homed(a);
        REQUIRE(a.drive.run(set_homing_profile{60 * r_per_min, 30 * r_per_min}));
        REQUIRE(a.drive.run(move_by{100 * pulse, brisk}));
        REQUIRE(a.drive.motion() == motion_check::seen);
        REQUIRE(a.drive.run(wait_reached{}));
        const command_status refusal = is_homing ? a.drive.begin(closed_loop::home{homing::home_24})
                                                 : a.drive.begin(move_by{900 * pulse, brisk});
        REQUIRE(refusal);
        const auto starts = a.model.starts();
        while (!a.drive.is_idle()) {
            if (a.model.starts() != starts || a.is_moving()) a.wire.faults().lost_response = 1000;
            a.turn();
        }
        a.wire.faults() = {};
        CHECK(a.drive.last().outcome() == outcome::unknown);
        CHECK(a.drive.motion() == motion_check::unknown);
        CHECK(a.drive.arrival().how == arrival_state::none);
    }
}

TEST_CASE("the first read of a command is repeated as often as the node says") {
    closed_axis a;
    take(a);
    const std::size_t before = a.requests.size();
    a.wire.set_connected(0, false);
    CHECK(a.drive.run(set_profile{brisk}).outcome() == outcome::not_sent);
    CHECK(a.requests.size() == before + 1 + node<yako::closed_loop::device>{1}.read_retries);
}

} // namespace drive_yako_faults_drive_tests
