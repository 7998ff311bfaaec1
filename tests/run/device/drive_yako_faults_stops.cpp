// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stops of the YAKOTEC facades: one that pre-empts a command after each of its frames, one whose own response
// is late or lost, and one that is sent after a command timeout or because the outcome of a homing is
// unknown.
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>
#include <tests/support/transaction_fault.hpp>

namespace drive_yako_faults_stops_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::gentle;
using enabled_yako::quick_stop_frame;
using enabled_yako::stop_frame;
using enabled_yako::take;
using enabled_yako::take_homed;
using simulated::closed_axis;
using simulated::run_with_a_loss;

namespace {

void step_for(closed_axis& a, std::uint32_t ms) {
    for (const std::uint64_t end = a.wire.time_us() + ms * 1000u; a.wire.time_us() < end;) a.turn();
}

} // namespace

TEST_CASE("G25: a stop during any command is the next frame after the one in progress, and the axis stops") {
    const auto check = [](const auto& wanted, bool is_quick) {
        for (std::size_t frames = 0; frames < 14; ++frames) {
            closed_axis a;
            a.model.attach(simulated::yako_slide());
            take(a);
            a.begin_up_to(wanted, frames);
            if (a.drive.is_idle()) break;
            a.requests.clear();
            if (is_quick) {
                REQUIRE(a.drive.begin(quick_stop{}) == errc::ok);
            } else {
                REQUIRE(a.drive.begin(halt{}) == errc::ok);
            }
            a.finish();
            REQUIRE(a.drive.last());
            const bytes wanted_frame = is_quick ? bytes{quick_stop_frame} : bytes{stop_frame};
            REQUIRE(a.requests.size() >= 2);
            CHECK((same_bytes(a.requests[0], wanted_frame) || same_bytes(a.requests[1], wanted_frame)));
            CHECK_FALSE(a.is_moving());
            const std::int64_t place = a.place();
            a.run(2000);
            CHECK(a.place() == place);
            CHECK(a.drive.run(move_to{0 * pulse, brisk}).outcome() == outcome::not_sent);
        }
    };
    for (const bool is_quick : {false, true}) {
        check(move_by{3000 * pulse, gentle}, is_quick);
        check(velocity{60 * r_per_min}, is_quick);
        check(bounded_jog{3000 * pulse, gentle}, is_quick);
        check(hold{60 * r_per_min, milliseconds(50)}, is_quick);
        check(closed_loop::home{homing::home_24}, is_quick);
        check(enable{}, is_quick);
        check(save{}, is_quick);
        check(wait_standstill{}, is_quick);
        check(set_profile{brisk}, is_quick);
        check(set_word_order{word_order_setting::low_first}, is_quick);
        check(set_speed_resolution{speed_count::tenth_r_per_min}, is_quick);
        check(set_position_segment{3, 100 * pulse, 60 * r_per_min}, is_quick);
        check(init{}, is_quick);
    }
}

TEST_CASE("G21: after a stop has pre-empted a command the cached state is correct or invalid") {
    SUBCASE("the word order") {
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            a.begin_up_to(set_word_order{word_order_setting::low_first}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(halt{}) == errc::ok);
            a.finish();
            const bool is_known = a.drive.state() != drive_state::needs_init;
            const auto held = a.model.peek(0x0019) == 0 ? word_order::high_first : word_order::low_first;
            if (is_known) CHECK(a.drive.cached().word_order == held);
        }
    }
    SUBCASE("the speed resolution") {
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            a.begin_up_to(set_speed_resolution{speed_count::tenth_r_per_min}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(halt{}) == errc::ok);
            a.finish();
            const bool is_known = a.drive.state() != drive_state::needs_init;
            if (is_known) CHECK(static_cast<u16>(a.drive.cached().resolution) == a.model.peek(0x001A));
        }
    }
    SUBCASE("a homing and a clear_position") {
        for (std::size_t frames = 0; frames < 40; ++frames) {
            closed_axis a;
            a.model.attach(simulated::yako_slide());
            take_homed(a);
            a.begin_up_to(closed_loop::home{homing::home_24}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(halt{}) == errc::ok);
            a.finish();
            // the declared position is still valid
            if (a.drive.cached().is_homed) CHECK(a.model.starts() == 1);
        }
        for (std::size_t frames = 0; frames < 6; ++frames) {
            closed_axis a;
            take(a);
            REQUIRE(a.drive.run(declare_position{500 * pulse}));
            a.begin_up_to(clear_position{}, frames);
            if (a.drive.is_idle()) break;
            REQUIRE(a.drive.begin(halt{}) == errc::ok);
            a.finish();
            if (a.drive.cached().is_homed) CHECK(a.place() == 500);
        }
    }
    SUBCASE("a stop of lower priority does not replace one of higher priority") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(velocity{60 * r_per_min}));
        REQUIRE(a.drive.begin(disable{}) == errc::ok);
        CHECK(a.drive.begin(halt{}) == errc::busy);
        a.finish();
        CHECK_FALSE(a.model.enabled());
        CHECK(a.drive.state() == drive_state::disabled);
    }
}

TEST_CASE("G26: a stop succeeds after the late response to a start, and the status word confirms it") {
    for (std::uint32_t late = 102; late < 130; late += 4) {
        closed_axis a;
        take(a);
        a.wire.faults().late_response = 1000;
        a.wire.faults().late_by = milliseconds(late);
        (void)a.drive.run(velocity{60 * r_per_min});
        CHECK(a.wire.struck() != 0);
        a.wire.faults() = {};
        REQUIRE(a.drive.run(halt{}));
        CHECK_FALSE(a.is_moving());
    }
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    REQUIRE(run_with_a_loss(a, halt{}, 0, true));
    CHECK(a.drive.last());
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G26: a stop that gets no response is repeated once in each period, not all the time") {
    closed_axis a;
    take(a);
    a.drive.repeat_stops(milliseconds(2000));
    a.wire.faults().lost_response = 1000;
    CHECK_FALSE(a.drive.run(halt{}));
    step_for(a, 3000); // the first repetition
    const std::size_t before = a.requests.size();
    step_for(a, 20'000);
    CHECK(a.requests.size() - before >= 9);
    CHECK(a.requests.size() - before <= 11 * 4); // a stop that is tried three times, and a read
}

TEST_CASE("G26: a release that is open is repeated as a release, also after a halt that got no response") {
    closed_axis a;
    take(a);
    a.drive.repeat_stops(milliseconds(500));
    a.wire.faults().lost_request = 1000;
    CHECK_FALSE(a.drive.run(disable{}));
    CHECK_FALSE(a.drive.run(halt{}));
    REQUIRE(a.model.enabled());
    a.wire.faults() = {};
    step_for(a, 5000);
    CHECK_FALSE(a.model.enabled());
}

TEST_CASE("G20, S4: the command timeout also stops an axis whose cached state is invalid") {
    const auto loop = [](closed_axis& a, std::uint32_t ms) {
        const std::uint64_t end = a.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (a.wire.time_us() < end) a.turn();
    };
    for (const bool takes_over : {false, true}) {
        closed_axis a;
        take(a);
        a.drive.set_command_timeout(milliseconds(1500));
        REQUIRE(a.drive.run(velocity{60 * r_per_min}));
        const auto stops = a.sent(stop_frame);
        a.wire.cut_for(milliseconds(1000));
        CHECK_FALSE(a.drive.read());
        CHECK(a.drive.state() == drive_state::needs_init);
        loop(a, 500);
        CHECK(a.is_moving());
        if (takes_over) {
            loop(a, 300);
            REQUIRE(a.drive.run(init{}));
            CHECK(a.sent(stop_frame) == stops + 1);
        }
        loop(a, 3000);
        CHECK(a.sent(stop_frame) == stops + 1); // once
        CHECK_FALSE(a.is_moving());
    }
    closed_axis a; // the command timeout does not pre-empt an init, which itself begins with a stop
    take(a);
    a.drive.set_command_timeout(milliseconds(400));
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.wire.cut_for(milliseconds(900));
    CHECK_FALSE(a.drive.read());
    a.run(1000);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

/// Begins a homing, which is under way and acknowledged afterwards.
template <class Axis> void home_until_acknowledged(Axis& a) {
    a.model.attach(simulated::yako_slide());
    take(a);
    REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!a.is_moving()) a.turn();
    const std::uint64_t acknowledged = a.wire.time_us() + 50'000;
    while (a.wire.time_us() < acknowledged) a.turn();
}

TEST_CASE("a homing whose outcome is unknown is stopped") {
    closed_axis a;
    home_until_acknowledged(a);
    a.wire.cut_for(milliseconds(500));
    a.finish();
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.sent(stop_frame) == 2); // the one of init, and this one
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G20: a homing is stopped whose state the drive refuses to show after the start") {
    using refusing_axis =
        simulated::driven_yako<simulated::refusing<sim::yako_closed_loop>, yako::closed_loop::drive>;
    refusing_axis a;
    home_until_acknowledged(a);
    a.model.refuses = true;
    while (a.model.refused == 0) a.turn();
    a.model.refuses = false;
    a.finish();
    CHECK(a.drive.last().error() == errc::exception);
    CHECK(a.drive.state() == drive_state::needs_init);
    CHECK(a.sent(stop_frame) == 2); // the one of init, and this one
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("G20: a homing whose start has no response is stopped, whether it began or not") {
    for (const bool is_response : {false, true}) {
        CAPTURE(is_response);
        unsigned begun = 0, lost = 0;
        for (std::uint32_t n = 0; n < 12; ++n) {
            closed_axis a;
            a.model.attach({.home_from = 20'000, .home_to = 21'000}); // ten seconds away
            take(a);
            REQUIRE(a.drive.run(set_homing_profile{120 * r_per_min, 30 * r_per_min}));
            const yako::closed_loop::home far{
                homing::home_24, {}, offset_handling::move_position_zero, milliseconds(1'000)};
            lost += simulated::run_with_a_loss(a, far, n, is_response) ? 1u : 0u;
            begun += a.model.starts() != 0 ? 1u : 0u;
            a.run(100);
            CHECK_FALSE(a.is_moving());
            CHECK_FALSE(a.drive.cached().is_homed);
        }
        CHECK(lost == 12);
        CHECK(begun >= 9);
    }
}

TEST_CASE("5.4: a set_input_move that is interrupted at any frame leaves the old move, the new one, or "
          "none") {
    using enum positioning;
    for (const bool is_absolute : {false, true}) {
        std::size_t n = 0;
        for (bool is_over = false; !is_over; ++n) {
            closed_axis a;
            take(a);
            REQUIRE(a.drive.run(disable{}));
            REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::position_move}));
            REQUIRE(a.drive.run(enable{}));
            REQUIRE(a.drive.run(declare_position{30 * pulse}));
            const set_input_move by_40{40 * pulse, brisk, relative};
            const set_input_move to_130{130 * pulse, brisk, absolute};
            const set_input_move to_70{70 * pulse, brisk, absolute};
            const set_input_move by_100{100 * pulse, brisk, relative};
            REQUIRE(a.drive.run(is_absolute ? by_40 : to_70));
            a.begin_up_to(is_absolute ? to_130 : by_100, n);
            is_over = a.drive.is_idle();
            a.run(5);
            a.model.set_input(3, true);
            a.run(200);
            const std::int64_t way = a.place() - 30;
            CHECK((way == (is_over ? 100 : 0) || (!is_over && (way == 40 || way == 100))));
        }
        CHECK(n > 4);
    }
}

TEST_CASE("G26: a disable that is open is still repeated after the command timeout has stopped the motor") {
    for (const std::uint32_t timeout : {200u, 500u, 2000u}) {
        CAPTURE(timeout);
        simulated::closed_axis a;
        enabled_yako::take(a);
        a.drive.set_command_timeout(milliseconds(timeout));
        const auto live = [&](std::uint32_t ms) {
            const std::uint64_t end = a.wire.time_us() + ms * 1000u;
            while (a.wire.time_us() < end) a.turn();
        };
        REQUIRE(a.drive.run(velocity{60 * units::r_per_min}));
        live(100);
        a.wire.faults().lost_request = 1000;
        REQUIRE(a.drive.begin(disable{}) == errc::ok);
        for (unsigned i = 0; !a.drive.is_idle(); ++i) {
            REQUIRE(i < 10'000);
            live(1);
        }
        REQUIRE_FALSE(a.drive.last());
        a.wire.faults() = {};
        live(10'000);
        CHECK_FALSE(a.model.enabled());
        REQUIRE(a.drive.run(init{}));
        CHECK(a.drive.state() == drive_state::disabled);
    }
}

} // namespace drive_yako_faults_stops_tests
