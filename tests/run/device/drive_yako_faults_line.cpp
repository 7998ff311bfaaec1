// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC facades on a line with faults: each frame of a command is lost, a port is lost and returns,
// frames are corrupted. A start is sent at most once, and an unknown outcome leaves no stale value.
#include <cstdint>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace drive_yako_faults_line_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::enable_frame;
using enabled_yako::save_frame;
using enabled_yako::start_homing_frame;
using enabled_yako::start_jog_frame;
using enabled_yako::start_relative_frame;
using enabled_yako::take;
using enabled_yako::take_homed;
using simulated::closed_axis;
using simulated::open_axis;
using simulated::run_with_a_loss;

namespace {

constexpr auto clear_alarm_frame = hex("01 06 00 2D 00 21 D9 DB");

} // namespace

TEST_CASE("S4, G15: a move is made at most once, whichever frame is lost; after a start of unknown outcome "
          "positions are compared") {
    unsigned seen = 0;
    unsigned not_seen = 0;
    unsigned unknown = 0;
    for (std::uint32_t lost = 0; lost < 8; ++lost) {
        for (const bool is_response : {false, true}) {
            closed_axis a;
            take_homed(a);
            const bool was_lost = run_with_a_loss(a, move_by{1000 * pulse, brisk}, lost, is_response);
            CHECK((was_lost || lost > 4));
            CHECK(a.sent(start_relative_frame) <= 1);
            const command_status ended = a.drive.last();
            a.run(3000);
            const bool was_made = a.place() == 1000;
            CHECK((was_made || a.place() == 0));
            if (ended) CHECK(was_made);
            if (ended.outcome() == outcome::not_sent || ended.outcome() == outcome::refused)
                CHECK_FALSE(was_made);
            if (ended.outcome() != outcome::unknown) continue;
            ++unknown;
            CHECK(a.drive.state() == drive_state::needs_init);
            CHECK(a.drive.run(move_by{1000 * pulse, brisk}).error() == errc::needs_init);
            if (a.drive.motion() == motion_check::not_asked) CHECK_FALSE(was_made);
        }
    }
    for (const bool is_response : {false, true}) { // the start is the fourth frame
        closed_axis a;
        take_homed(a);
        REQUIRE(run_with_a_loss(a, move_by{1000 * pulse, brisk}, 3, is_response));
        CHECK(a.drive.last().outcome() == outcome::unknown);
        if (a.drive.motion() == motion_check::seen) ++seen;
        if (a.drive.motion() == motion_check::not_seen) ++not_seen;
        a.run(3000);
        CHECK(a.place() == (is_response ? 1000 : 0));
        REQUIRE(a.drive.run(init{}));
        CHECK(a.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing); // and not by itself
    }
    CHECK(unknown == 4);
    CHECK(seen == 1);
    CHECK(not_seen == 1);
}

TEST_CASE_TEMPLATE(
    "S4, G15: a short move whose acknowledgement is lost is seen by its end, in either direction", A,
    closed_axis, open_axis) {
    for (const std::int32_t from : {0, 500, -500}) {
        for (const std::int32_t way : {100, -100, 600, -600}) {
            for (const bool is_made : {true, false}) {
                CAPTURE(from);
                CAPTURE(way);
                CAPTURE(is_made);
                A a;
                take(a);
                REQUIRE(a.drive.run(declare_position{from * pulse}));
                REQUIRE(run_with_a_loss(a, move_by{way * pulse, brisk}, 3,
                                        is_made));                        // the start is the fourth frame
                CHECK(a.sent(start_relative_frame) == (is_made ? 1 : 0)); // those that the drive got
                CHECK(a.drive.last().outcome() == outcome::unknown);
                CHECK(a.drive.motion() == (is_made ? motion_check::seen : motion_check::not_seen));
                CHECK_FALSE(a.is_moving()); // so the position alone has shown it
                CHECK(a.place() == (is_made ? from + way : from));
            }
        }
    }
}

TEST_CASE("if the line breaks between the response to a start and the read that confirms it, the outcome is "
          "unknown") {
    for (const bool is_homing : {false, true}) {
        closed_axis a;
        take(a);
        const std::uint32_t before = a.wire.requests();
        if (is_homing) {
            REQUIRE(a.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
        } else {
            REQUIRE(a.drive.begin(velocity{60 * r_per_min}) == errc::ok);
        }
        while (a.model.starts() == 0) a.turn();
        REQUIRE(a.wire.requests() > before);
        a.run(1);
        a.wire.cut_for(milliseconds(5000));
        a.finish();
        CHECK(a.drive.last().outcome() == outcome::unknown);
        CHECK(a.drive.state() == drive_state::needs_init);
        a.run(6000);
        REQUIRE(a.drive.run(init{}));
        CHECK_FALSE(a.is_moving());
    }
}

TEST_CASE("G15: whatever the line does, starts, enable, alarm clear and save are sent at most once per "
          "call") {
    unsigned struck = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        closed_axis a{{}, seed};
        take(a);
        a.wire.faults() = {.lost_request = 50,
                           .corrupted_request = 50,
                           .lost_response = 100,
                           .late_response = 50,
                           .doubled_response = 50,
                           .corrupted_response = 50};
        const auto once = [&](bytes frame, const auto& wanted) {
            if (a.drive.state() == drive_state::needs_init) (void)a.drive.run(init{});
            a.requests.clear();
            const std::uint32_t starts = a.model.starts();
            (void)a.drive.run(wanted);
            CHECK(a.sent(frame) <= 1);
            CHECK(a.model.starts() <= starts + 1);
            (void)a.drive.run(halt{});
        };
        once(start_relative_frame, move_by{100 * pulse, brisk});
        once(start_jog_frame, velocity{60 * r_per_min});
        once(start_relative_frame, bounded_jog{100 * pulse, brisk});
        once(modbus::write_frame(1, 0x0027, 0x000D), hold{60 * r_per_min, milliseconds(50)});
        once(start_homing_frame,
             closed_loop::home{homing::home_24, {}, offset_handling::stay_position_zero, milliseconds(500)});
        once(save_frame, save{});
        once(clear_alarm_frame, fault_reset{});
        once(enable_frame, enable{});
        struck += a.wire.struck();
    }
    REQUIRE(struck > 1000);
}

TEST_CASE("S6: while the word order is unknown no 32-bit value is sent; a lost response makes it unknown") {
    closed_axis a;
    take_homed(a);
    a.wire.faults().lost_response = 0;
    REQUIRE(run_with_a_loss(a, set_word_order{word_order_setting::low_first}, 2, true));
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.model.peek(0x0019) == 1); // the drive executed it
    CHECK(a.drive.cached().word_order == word_order::unknown);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(move_by{70'000 * pulse, brisk}).error() == errc::needs_init);
    CHECK(a.drive.run(declare_position{0 * pulse}).error() == errc::needs_init);
    CHECK(a.drive.run(limit_travel{0 * pulse, 1 * pulse}).error() == errc::needs_init);
    CHECK(a.drive.run(set_position_segment{1, 1 * pulse, 1 * r_per_min}).error() == errc::needs_init);
    CHECK(a.drive.read().error() == errc::needs_init);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.cached().word_order == word_order::low_first);
    REQUIRE(a.drive.run(move_by{70'000 * pulse, brisk}));
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK(a.place() == 70'000);
}

TEST_CASE("G16, G21: an unknown outcome invalidates the cached state; nothing moves before init") {
    closed_axis a;
    take_homed(a);
    REQUIRE(run_with_a_loss(a, set_profile{brisk}, 2, true));
    CHECK(a.drive.last().outcome() == outcome::unknown);
    CHECK(a.drive.state() == drive_state::needs_init);
    const auto frames = a.requests.size();
    CHECK(a.drive.run(move_by{1 * pulse, brisk}).outcome() == outcome::not_sent);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(init{}));
    CHECK(a.drive.run(move_to{1 * pulse, brisk}).error() == errc::needs_homing);
    REQUIRE(a.drive.run(accept_position{}));
    REQUIRE(a.drive.run(move_to{1 * pulse, brisk}));
}

TEST_CASE("G21: after a lost port has returned, init is required, and it stops the axis") {
    closed_axis a;
    take_homed(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    a.wire.unplug();
    CHECK(a.drive.read().error() == errc::port_lost);
    CHECK(a.drive.run(init{}).error() == errc::port_lost);
    a.run(2000);
    CHECK(a.is_moving()); // S4: no watchdog stops it
    a.wire.plug();
    CHECK(a.drive.run(velocity{60 * r_per_min}).error() == errc::needs_init);
    REQUIRE(a.drive.run(init{}));
    CHECK_FALSE(a.is_moving());
}

TEST_CASE("on a line with random faults init stops the axis and makes it usable again") {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        sim::yako_closed_loop model;
        sim::station at{model};
        sim::virtual_line wire{115200, seed};
        wire.attach(at);
        servobus::line on{wire, modbus::timing_at(115200)};
        closed_loop::drive axis{on, 1};
        sim::fault_plan plan;
        REQUIRE(sim::parse_faults("late,lossy,noisy,doubled", plan));
        wire.faults() = plan;
        unsigned rounds = 0;
        for (int i = 0; i < 40; ++i) {
            if (!axis.run(init{})) continue;
            CHECK_FALSE(model.view().is_moving);
            if (!axis.run(enable{})) continue;
            const std::int64_t before = model.view().position;
            if (!axis.run(move_by{200 * pulse, brisk})) continue;
            if (!axis.run(wait_standstill{})) continue;
            CHECK(model.view().position == before + 200);
            ++rounds;
        }
        CHECK(rounds > 5);
        CHECK(wire.struck() != 0);
        wire.faults() = {};
        REQUIRE(axis.run(init{}));
        CHECK_FALSE(model.view().is_moving);
    }
}

TEST_CASE("G25, A4: a stop or a read that the drive reports as corrupted is repeated") {
    closed_axis a{{.answers_bad_crc = true}};
    take(a);
    REQUIRE(a.drive.run(velocity{60 * r_per_min}));
    const auto damaged_first = [&](const auto& wanted) {
        a.wire.faults().corrupted_request = 1000;
        REQUIRE(a.drive.begin(wanted) == errc::ok);
        const std::uint32_t first = a.wire.requests();
        while (!a.drive.is_idle()) {
            if (a.wire.requests() > first) a.wire.faults().corrupted_request = 0;
            a.turn();
        }
        return a.drive.last();
    };
    CHECK(damaged_first(halt{}));
    CHECK(a.wire.struck() == 1);
    CHECK_FALSE(a.is_moving());
    CHECK(damaged_first(disable{}));
    CHECK(a.wire.struck() == 2);
    CHECK_FALSE(a.model.enabled());
    client direct{a.line, node<closed_loop::device>{1}};
    a.wire.faults().corrupted_request = 1000; // every try is corrupted
    const auto refused = direct.read<error_code>();
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 1);
}

} // namespace drive_yako_faults_line_tests
