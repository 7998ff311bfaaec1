// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// YAKOTEC steppers that turn while a command is repeated: how far the motor turns on by the simulator's own position
// when the program, the line or the drive ends the repetition, and that it never rests in between.
#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <initializer_list>

#include <tests/support/driven_yako.hpp>
#include <tests/support/yako_interpretations.hpp>

namespace hold_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

template <class A> void take(A& a) {
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
}
constexpr held_velocity held(speed target, duration every, yako::time rise = yako::time{100},
                             yako::time fall = yako::time{100}) {
    return {target, every, rise, fall};
}
constexpr held_velocity at_60 = held(60 * r_per_min, milliseconds(50));
constexpr std::int64_t reach_of_60 = yako::reach(at_60, {.microsteps = 1000}).count(); // 252 pulses

/// What was seen while a command was repeated.
struct repetition {
    unsigned commands = 0;
    unsigned failures = 0;
    unsigned rests = 0; // looks at a motor that rests, once it has begun to move
    errc error = errc::ok;
};
/// Repeats a command for a time. `ends_at_error`: the program does so too.
template <class A, class Command>
repetition repeat(A& a, const Command& wanted, duration every, std::uint32_t ms, bool ends_at_error = false) {
    repetition seen;
    const std::uint64_t end = a.wire.time_us() + 1000 * std::uint64_t{ms};
    std::uint64_t due = a.wire.time_us();
    bool has_moved = false;
    bool is_under_way = false;
    while (a.wire.time_us() < end) {
        has_moved = has_moved || a.is_moving();
        if (has_moved && !a.is_moving()) ++seen.rests;
        if (is_under_way && a.drive.is_idle()) {
            is_under_way = false;
            if (!a.drive.last()) {
                ++seen.failures;
                seen.error = a.drive.last().error();
                if (ends_at_error) return seen;
            }
        }
        if (a.drive.is_idle() && a.wire.time_us() >= due) {
            due = a.wire.time_us() + every.us;
            ++seen.commands;
            is_under_way = a.drive.begin(wanted) == errc::ok;
            if (!is_under_way) ++seen.failures;
        }
        a.turn();
    }
    return seen;
}
/// How far the motor turns on by itself. Nothing is sent meanwhile.
template <class A> std::int64_t run_on(A& a, std::uint32_t ms = 6000) {
    const std::int64_t from = a.place();
    a.run(ms);
    CHECK_FALSE(a.is_moving());
    return a.place() - from;
}
template <class A> std::int64_t reach_of(const A& a, const held_velocity& h) {
    return yako::reach(h, a.drive.cached()).count();
}

} // namespace

TEST_CASE("the reach is the speed times twice the period, 50 ms and the deceleration, whatever a count and a "
          "turn are") {
    for (const std::uint16_t microsteps : std::initializer_list<std::uint16_t>{400, 1000, 12'345, 51'200}) {
        for (const std::int32_t tenths : {1, 10, 600, 6000, 30'000}) {
            for (const std::uint32_t ms : {1u, 20u, 50u, 100u, 1000u}) {
                for (const std::int32_t ramp : {0, 100, 2000}) {
                    const cached_settings known{.microsteps = microsteps};
                    const held_velocity up =
                        held(speed{tenths}, milliseconds(ms), yako::time{}, yako::time{ramp});
                    const std::int64_t exact =
                        std::int64_t{tenths} * microsteps * (2 * std::int64_t{ms} + 50 + ramp) / 600'000;
                    const std::int64_t reach = yako::reach(up, known).count();
                    CAPTURE(exact);
                    CHECK(reach >= exact);
                    CHECK(reach <= exact + exact / 50 + 32);
                    const held_velocity down =
                        held(speed{-tenths}, milliseconds(ms), yako::time{}, yako::time{ramp});
                    CHECK(yako::reach(down, known).count() == -reach);
                }
            }
        }
    }
}

TEST_CASE_TEMPLATE("S4: a motor turns at its speed while the command is repeated, and stops within the reach "
                   "after the program does",
                   A, closed_axis, open_axis) {
    for (const std::uint32_t every : {10u, 20u, 50u, 100u}) {
        for (const std::int32_t turns : {60, -60, 600}) {
            for (const auto order : {word_order_setting::high_first, word_order_setting::low_first}) {
                CAPTURE(every);
                CAPTURE(turns);
                A a;
                take(a);
                REQUIRE(a.drive.run(set_word_order{order}));
                const held_velocity h = held(turns * r_per_min, milliseconds(every));
                const std::int64_t reach = reach_of(a, h);
                const std::int64_t from = a.place();
                const repetition seen = repeat(a, h, h.every, 3000);
                CHECK(seen.failures == 0);
                CHECK(seen.rests == 0);
                CHECK(seen.commands >= 3000 / (every + 30));
                // 1000 pulses a turn: all but the ramp at the beginning.
                const std::int64_t way = std::abs(a.place() - from);
                CHECK(way >= 3000 * std::abs(turns) / 60 * 95 / 100 - 3 * std::abs(turns));
                CHECK(way <= 3000 * std::abs(turns) / 60);
                CHECK(a.model.view().speed == turns * 1'000'000);
                const std::int64_t on = run_on(a);
                CHECK(std::abs(on) <= std::abs(reach));
                CHECK((on < 0) == (turns < 0));
            }
        }
    }
}

TEST_CASE_TEMPLATE("S4: at whichever frame the program stops, the motor rests within the reach", A,
                   closed_axis, open_axis) {
    std::int64_t least = 1000;
    std::int64_t most = 0;
    for (std::uint32_t ms = 500; ms < 600; ++ms) {
        CAPTURE(ms);
        A a;
        take(a);
        CHECK(repeat(a, at_60, at_60.every, ms).failures == 0);
        const std::int64_t on = run_on(a);
        CHECK(on <= reach_of_60);
        least = on < least ? on : least;
        most = on > most ? on : most;
    }
    CHECK(least >= 180); // 190..240 of 252 pulses
    CHECK(most >= 230);
}

TEST_CASE("a program that steps and does not repeat: the motor rests within the reach, and no supervisor "
          "stops it") {
    for (const command_timeout limit : {no_command_timeout, command_timeout{milliseconds(100)}}) {
        closed_axis a;
        closed_loop::drive polled{a.line, 1, {.feedback = milliseconds(20), .command_timeout = limit}};
        const auto live = [&](std::uint32_t ms) {
            for (const std::uint64_t end = a.wire.time_us() + 1000 * ms; a.wire.time_us() < end;) {
                const duration idle = polled.step();
                a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
            }
        };
        REQUIRE(polled.run(init{}));
        REQUIRE(polled.run(enable{}));
        for (int i = 0; i < 20; ++i) {
            REQUIRE(polled.run(at_60));
            live(20);
            CHECK(a.is_moving());
        }
        const std::int64_t from = a.place();
        const std::size_t stops = a.sent(modbus::write_frame(1, 0x0027, 0x0100));
        live(2000);
        CHECK_FALSE(a.is_moving());
        CHECK(a.place() - from <= reach_of_60);
        CHECK(a.sent(modbus::write_frame(1, 0x0027, 0x0100)) == stops);
        CHECK(polled.state() == drive_state::enabled);
        CHECK(polled.run(at_60));
    }
}

TEST_CASE("at 9600 Bd a command takes 200 ms, and the motor turns from one to the next") {
    simulated::simulated_model<sim::yako_closed_loop, sim::yako_options, 9600> a{
        {.kept = sim::yako_kept::written}};
    const std::uint8_t slow[]{0, static_cast<std::uint8_t>(baud_rate::baud_9600)};
    REQUIRE(a.model.write(rs485_baud_rate.address, words_view{slow}) == 0);
    a.model.power_cycle();
    a.run(100);
    closed_loop::drive axis{a.line, 1, unsupervised};
    REQUIRE(axis.run(init{}));
    REQUIRE(axis.run(enable{}));
    const held_velocity h = held(60 * r_per_min, milliseconds(200));
    for (int i = 0; i < 20; ++i) {
        CHECK((i == 0 || a.model.view().is_moving));
        const std::uint64_t from = a.wire.time_us();
        REQUIRE(axis.run(h));
        CHECK(a.wire.time_us() - from < 210'000);
    }
    const std::int64_t from = a.model.view().position;
    a.run(3000);
    CHECK_FALSE(a.model.view().is_moving);
    CHECK(a.model.view().position - from <= yako::reach(h, axis.cached()).count());
}

TEST_CASE_TEMPLATE("a hold needs no home, and keeps none from being lost", A, closed_axis, open_axis) {
    A a;
    take(a);
    CHECK_FALSE(a.drive.cached().is_homed);
    CHECK(repeat(a, at_60, at_60.every, 500).failures == 0);
    CHECK(a.drive.run(move_to{0 * pulse}).error() == errc::needs_homing);
}

TEST_CASE_TEMPLATE("release is halt, which stops by the ramp", A, closed_axis, open_axis) {
    A a;
    take(a);
    CHECK(repeat(a, at_60, at_60.every, 500).failures == 0);
    while (!a.drive.is_idle()) a.turn();
    const std::int64_t from = a.place();
    REQUIRE(a.drive.run(halt{}));
    CHECK_FALSE(a.is_moving());
    CHECK(a.place() - from <= 120); // 100 ms to standstill at 1000 pulses a second, and the frames
    CHECK(run_on(a) == 0);
}

TEST_CASE("another direction, speed or ramp waits for standstill, and so does another motion") {
    closed_axis a;
    take(a);
    const auto refuses = [&](const auto& wanted) {
        CHECK(a.drive.run(at_60));
        const std::uint32_t starts = a.model.starts();
        CHECK(a.drive.run(wanted).error() == errc::busy);
        CHECK(a.model.starts() == starts);
        CHECK(a.drive.run(at_60)); // the refused one has not ended it
    };
    refuses(hold{-60 * r_per_min, milliseconds(50)});
    refuses(hold{61 * r_per_min, milliseconds(50)});
    refuses(hold{60 * r_per_min, milliseconds(50), 90 * millisecond, 100 * millisecond});
    refuses(hold{60 * r_per_min, milliseconds(50), 100 * millisecond, 90 * millisecond});
    refuses(bounded_jog{-100 * pulse});
    refuses(velocity{60 * r_per_min});
    refuses(move_by{100 * pulse});
    CHECK(a.drive.run(hold{60 * r_per_min, milliseconds(90)})); // another period is no other motion
    CHECK(a.drive.run(at_60));
    // The profile that the drive holds is not that of the motion any more.
    REQUIRE(a.drive.run(set_profile{{{}, 50 * millisecond, 50 * millisecond, 60 * r_per_min}}));
    CHECK(a.drive.run(hold{60 * r_per_min, milliseconds(50), 50 * millisecond, 50 * millisecond}).error() ==
          errc::busy);
    REQUIRE(a.drive.run(halt{}));
    CHECK(repeat(a, held(-120 * r_per_min, milliseconds(50)), milliseconds(50), 500).failures == 0);
    CHECK(a.model.view().speed == -120'000'000);
    REQUIRE(a.drive.run(halt{}));
    // Nor does a hold continue a motion of another kind.
    for (int other = 0; other < 3; ++other) {
        if (other == 0) REQUIRE(a.drive.run(bounded_jog{2000 * pulse}));
        if (other == 1) REQUIRE(a.drive.run(move_by{2000 * pulse}));
        if (other == 2) REQUIRE(a.drive.run(velocity{60 * r_per_min}));
        const bool is_same = other == 0; // the profile that the last hold has left
        CHECK(a.drive.run(hold{-120 * r_per_min, milliseconds(50)}).error() == errc::busy);
        CHECK(a.drive.run(hold{120 * r_per_min, milliseconds(50)}).error() ==
              (is_same ? errc::ok : errc::busy));
        REQUIRE(a.drive.run(halt{}));
    }
    // A bounded jog leaves it its target.
    REQUIRE(a.drive.run(at_60));
    const std::uint32_t starts = a.model.starts();
    REQUIRE(a.drive.run(bounded_jog{2000 * pulse}));
    CHECK(a.model.starts() == starts);
    CHECK(run_on(a) <= reach_of_60);
    // A move to a place may interrupt it.
    REQUIRE(a.drive.run(declare_position{0 * pulse}));
    REQUIRE(a.drive.run(at_60));
    REQUIRE(a.drive.run(move_to{-50 * pulse, {}, while_moving::interrupt}));
    CHECK(a.drive.run(wait_reached{}));
    CHECK(a.place() == -50);
}

TEST_CASE("G34: after a hold no arrival is reported and no end at a target is waited for") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{50 * pulse}, wait_reached{}).how == arrival_state::reached);
    for (int i = 0; i < 3; ++i) {
        REQUIRE(a.drive.run(at_60));
        CHECK(a.drive.motion() == motion_check::seen);
        CHECK(a.drive.arrival().how == arrival_state::none);
        CHECK(a.drive.run(wait_reached{}).error() == errc::wrong_state);
    }
    REQUIRE(a.drive.run(wait_standstill{}));
    CHECK_FALSE(a.is_moving());
    REQUIRE(a.drive.read());
    CHECK(a.drive.arrival().how == arrival_state::none);
}

TEST_CASE_TEMPLATE("G20, G21: on a line that loses frames the motor turns on by no more than the reach, and "
                   "only init starts anew",
                   A, closed_axis, open_axis) {
    std::uint32_t struck = 0;
    unsigned ended = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        A a{{}, seed};
        take(a);
        const std::uint32_t before = a.wire.struck();
        a.wire.faults().lost_request = 10;
        a.wire.faults().lost_response = 10;
        a.wire.faults().corrupted_response = 10;
        const repetition seen = repeat(a, at_60, at_60.every, 2000, true);
        a.wire.faults() = {};
        struck += a.wire.struck() - before;
        CHECK(run_on(a) <= reach_of_60 + 120); // it may have ended some frames ago
        if (seen.failures == 0) continue;
        ++ended;
        a.finish();
        const std::uint32_t starts = a.model.starts();
        CHECK(a.drive.run(at_60).error() == errc::needs_init);
        CHECK(a.model.starts() == starts);
        take(a);
        CHECK(a.drive.run(at_60));
    }
    CHECK(struck > 60);
    CHECK(ended > 20);
    CHECK(ended < 60);
}

TEST_CASE_TEMPLATE("G21: each frame of a hold that is lost: the motor stops within the reach of where it was",
                   A, closed_axis, open_axis) {
    unsigned played = 0;
    unsigned needs_init = 0;
    for (const bool is_response : {false, true}) {
        for (std::uint32_t lost = 0;; ++lost) {
            CAPTURE(lost);
            CAPTURE(is_response);
            A a;
            take(a);
            CHECK(repeat(a, at_60, at_60.every, 300).failures == 0);
            a.finish();
            const std::int64_t from = a.place();
            if (!run_with_a_loss(a, at_60, lost, is_response)) break;
            ++played;
            if (!a.drive.last()) {
                CHECK(a.drive.last().outcome() != outcome::not_sent);
                ++needs_init;
                CHECK(a.drive.state() == drive_state::needs_init);
            }
            a.run(6000);
            CHECK_FALSE(a.is_moving());
            // The position of the command was read a lost response after `from` at the latest.
            CHECK(a.place() - from <= 220 + reach_of_60);
        }
    }
    CHECK(played == 12);
    CHECK(needs_init == 4); // the target and the start, a request or its response
}

TEST_CASE_TEMPLATE(
    "S4: when the line is lost the motor stops within the reach, and nothing starts when it returns", A,
    closed_axis, open_axis) {
    for (std::uint32_t ms = 200; ms < 260; ms += 3) {
        A a;
        take(a);
        CHECK(repeat(a, at_60, at_60.every, ms).failures == 0);
        a.wire.faults().lost_request = 1000;
        const std::uint32_t struck = a.wire.struck();
        const std::int64_t from = a.place();
        const repetition seen = repeat(a, at_60, at_60.every, 3000);
        CHECK(a.wire.struck() > struck);
        CHECK(seen.failures != 0);
        CHECK_FALSE(a.is_moving());
        CHECK(a.place() - from <= reach_of_60);
        a.wire.faults() = {};
        const std::int64_t there = a.place();
        for (int i = 0; i < 1000; ++i) a.turn();
        a.run(1000);
        CHECK(a.place() == there);
    }
}

TEST_CASE_TEMPLATE("G21: a restart while the command is repeated ends it", A, closed_axis, open_axis) {
    for (std::uint32_t ms = 200; ms < 280; ms += 2) {
        CAPTURE(ms);
        A a;
        take(a);
        CHECK(repeat(a, at_60, at_60.every, ms).failures == 0);
        a.model.power_cycle();
        const std::int64_t from = a.model.view().shaft;
        const repetition seen = repeat(a, at_60, at_60.every, 2000);
        CHECK(seen.failures != 0);
        CHECK(a.drive.state() == drive_state::needs_init);
        CHECK_FALSE(a.is_moving());
        CHECK(std::abs(a.model.view().shaft - from) <= reach_of_60);
    }
}

TEST_CASE("the end of the counter's range refuses a target beyond it, and the motor stops before") {
    for (const std::int32_t turns : {60, -60}) {
        closed_axis a;
        take(a);
        const std::int32_t end = turns > 0 ? 2'147'482'000 : -2'147'482'000;
        REQUIRE(a.drive.run(declare_position{end * pulse}));
        const held_velocity h = held(turns * r_per_min, milliseconds(50));
        const repetition seen = repeat(a, h, h.every, 3000);
        CHECK(seen.failures != 0);
        CHECK(seen.error == errc::out_of_range);
        CHECK_FALSE(a.is_moving());
        CHECK(a.drive.state() == drive_state::enabled);
        const std::int64_t rest = std::abs(a.place()) - 2'147'482'000;
        CHECK(rest > 0);
        CHECK(rest <= 1647);
        CHECK(repeat(a, held(-turns * r_per_min, milliseconds(50)), milliseconds(50), 500).failures == 0);
    }
}

TEST_CASE("software limits, limit inputs and stop inputs end it as any move") {
    SUBCASE("a software limit") {
        closed_axis a;
        take(a);
        REQUIRE(a.drive.run(declare_position{0 * pulse}));
        REQUIRE(a.drive.run(limit_travel{-700 * pulse, 700 * pulse}));
        REQUIRE(a.drive.run(set_over_travel_stop{over_travel_stop::emergency_stop}));
        (void)repeat(a, at_60, at_60.every, 3000);
        a.finish();
        CHECK(a.place() >= 700);
        CHECK(a.place() <= 720);
        REQUIRE(a.drive.run(hold{-60 * r_per_min, milliseconds(50)})); // back
    }
    SUBCASE("a stop input") {
        closed_axis a;
        REQUIRE(a.drive.run(init{}));
        REQUIRE(a.drive.run(disable{}));
        REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::stop}));
        REQUIRE(a.drive.run(enable{}));
        CHECK(repeat(a, at_60, at_60.every, 500).failures == 0);
        a.model.set_input(3, true);
        const repetition seen = repeat(a, at_60, at_60.every, 2000);
        a.finish();
        CHECK_FALSE(a.is_moving());
        CHECK(seen.failures != 0);
        CHECK((seen.error == errc::not_executed || seen.error == errc::not_reached));
        a.model.set_input(3, false);
        CHECK(run_on(a) == 0);
        CHECK(a.drive.run(at_60));
    }
}

TEST_CASE("its arguments are checked before anything is sent") {
    closed_axis a;
    take(a);
    const std::size_t frames = a.requests.size();
    const auto refusal_of = [&](const held_velocity& h) { return a.drive.run(h).error(); };
    CHECK(refusal_of(held(0 * r_per_min, milliseconds(50))) == errc::out_of_range);
    CHECK(refusal_of(held(3001 * r_per_min, milliseconds(50))) == errc::out_of_range);
    CHECK(refusal_of(held(-2'147'483'647 * r_per_min, milliseconds(50))) == errc::out_of_range);
    CHECK(refusal_of(held(5 * part<10>(r_per_min), milliseconds(50))) == errc::inexact);
    CHECK(refusal_of(held(60 * r_per_min, milliseconds(0))) == errc::out_of_range);
    CHECK(refusal_of(held(60 * r_per_min, milliseconds(1001))) == errc::out_of_range);
    CHECK(refusal_of(held(60 * r_per_min, milliseconds(50), 2001 * millisecond)) == errc::out_of_range);
    CHECK(refusal_of(held(60 * r_per_min, milliseconds(50), yako::time{}, yako::time{-1})) ==
          errc::out_of_range);
    CHECK(yako::prepare(at_60, {.state = drive_state::enabled, .has_scale = true}).refusal ==
          errc::unexpected_value);
    CHECK(a.requests.size() == frames);
    REQUIRE(a.drive.run(disable{}));
    CHECK(refusal_of(at_60) == errc::wrong_state);
}

TEST_CASE(
    "0.1 r/min and other microsteps: the speed is the commanded one, and the motor stops within the reach") {
    for (const std::uint16_t microsteps : std::initializer_list<std::uint16_t>{400, 51'200}) {
        closed_axis a;
        const std::uint8_t word[]{static_cast<std::uint8_t>(microsteps >> 8),
                                  static_cast<std::uint8_t>(microsteps & 255)};
        REQUIRE(a.model.write(microstep_resolution.address, words_view{word}) == 0);
        take(a);
        REQUIRE(a.drive.run(set_speed_resolution{speed_count::tenth_r_per_min}));
        for (const std::int32_t tenths : {20, 605, -3000}) {
            CAPTURE(tenths);
            const held_velocity h = held(tenths * part<10>(r_per_min), milliseconds(20));
            const repetition seen = repeat(a, h, h.every, 3000);
            CHECK(seen.failures == 0);
            CHECK(seen.rests == 0);
            CHECK(a.model.view().speed == tenths * 100'000);
            CHECK(std::abs(run_on(a)) <= std::abs(reach_of(a, h)));
            a.finish();
        }
    }
}

TEST_CASE_TEMPLATE("S4: a hold stops within its reach under every interpretation of the manual" *
                       doctest::test_suite("interpretations"),
                   A, closed_axis, open_axis) {
    ::interpretations::under_yako([](const sim::yako_options& by, std::size_t, bool) -> std::size_t {
        A a{by};
        take(a);
        const held_velocity fast =
            held(3000 * r_per_min, milliseconds(50), 400 * millisecond, 400 * millisecond);
        for (const held_velocity& h : {at_60, fast}) {
            const repetition seen = repeat(a, h, h.every, 3000);
            CHECK(seen.failures == 0);
            if (!by.ramps_to_1000_r_per_min) CHECK(seen.rests == 0);
            CHECK(run_on(a, 20'000) <= reach_of(a, h));
            CHECK_FALSE(a.is_moving());
        }
        return 2;
    });
}

} // namespace hold_yako_tests
