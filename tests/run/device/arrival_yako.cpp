// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// G34, G35: how a move of a YAKO ends, judged by the simulated motor and by arithmetic on what was commanded;
// and what the drive's state says after an alarm, alone and polled.
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>
#include <tests/support/enabled_yako.hpp>

namespace arrival_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using enabled_yako::brisk;
using enabled_yako::gentle;
using enabled_yako::take;
using enabled_yako::take_homed;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

template <class A> struct polled {
    A a;
    decltype(A::drive) drive;

    explicit polled(sim::yako_options options = {}, supervision by = without_watchdog)
        : a{options}, drive{a.line, 1, by} {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable{}));
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = a.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (a.wire.time_us() < end) {
            const duration idle = drive.step();
            a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
        }
    }
};

} // namespace

TEST_CASE_TEMPLATE("G34: a move that reaches its target says so, whatever its kind", A, closed_axis,
                   open_axis) {
    A a;
    take_homed(a);
    CHECK(a.drive.arrival().how == arrival_state::none);
    CHECK(a.drive.run(wait_reached{}).error() == errc::wrong_state);
    std::int64_t target = 0;
    for (const std::int32_t way : {1000, -300, 7, -1, 5, 2, 20'000}) {
        CAPTURE(way);
        target += way;
        CHECK(a.drive.run(move_by{way * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
        CHECK(a.place() == target);
        target = -way;
        CHECK(a.drive.run(move_to{-way * pulse}, wait_reached{}).how == arrival_state::reached);
        CHECK(a.place() == target);
        CHECK(a.drive.arrival().missing == distance{0});
    }
    const arrival there = a.drive.run(move_to{-20'000 * pulse, brisk}, wait_reached{});
    CHECK(there.how == arrival_state::reached); // it was there
    REQUIRE(a.drive.run(bounded_jog{500 * pulse, brisk}));
    CHECK(a.drive.run(wait_reached{}));
    CHECK(a.place() == target + 500);
}

TEST_CASE("a wait goes on however many responses are lost, as long as others come between") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{50'000 * pulse, brisk}));
    REQUIRE(a.drive.begin(wait_reached{}) == errc::ok);
    const std::size_t before = a.requests.size();
    while (!a.drive.is_idle()) {
        a.wire.faults().lost_response = (a.requests.size() - before) % 6 == 5 ? 1000 : 0;
        const duration idle = a.drive.step();
        a.wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    REQUIRE(a.requests.size() - before > 4 * 6); // more than a read is repeated
    CHECK(a.drive.last());
    CHECK(a.drive.arrival().how == arrival_state::reached);
}

TEST_CASE("G34: a move that is refused has no arrival, and last() says why") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(disable{}));
    CHECK(a.drive.run(move_by{100 * pulse, brisk}, wait_reached{}).how == arrival_state::none);
    CHECK_FALSE(a.drive.last());
    CHECK(a.drive.run(move_to{100 * pulse, brisk}, wait_reached{}).how == arrival_state::none);
    CHECK(a.drive.last().error() == errc::needs_homing);
    CHECK(a.drive.last().outcome() == outcome::not_sent);
    // Nor that of the move before it.
    REQUIRE(a.drive.run(enable{}));
    REQUIRE(a.drive.run(move_by{100 * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
    CHECK(a.drive.run(move_to{200 * pulse, brisk}, wait_reached{}).how == arrival_state::none);
    CHECK(a.drive.last().error() == errc::needs_homing);
}

TEST_CASE_TEMPLATE("G34: while a move is under way arrival says how far it has to go", A, closed_axis,
                   open_axis) {
    polled<A> p;
    REQUIRE(p.drive.run(move_by{3000 * pulse, gentle}));
    CHECK(p.drive.arrival().how == arrival_state::under_way);
    for (int i = 0; i < 20; ++i) {
        p.loop(50);
        const arrival a = p.drive.arrival();
        CHECK(a.how == arrival_state::under_way);
        const std::int64_t missing = 3000 - p.a.place();
        CHECK(a.missing.count() >= missing);
        CHECK(a.missing.count() <= missing + 40); // 60 r/min for a feedback period and two frames
    }
    p.loop(5000);
    CHECK(p.drive.arrival().how == arrival_state::reached);
}

TEST_CASE_TEMPLATE("G34: a stop of the program, an alarm and a release end a move short of its target, with "
                   "their cause",
                   A, closed_axis, open_axis) {
    for (const int how : {0, 1, 2, 3, 4}) {
        CAPTURE(how);
        const bool is_alarm = how == 2 || how == 4;
        polled<A> p{{.alarm = how == 4 ? sim::yako_alarm::holds : sim::yako_alarm::releases}};
        REQUIRE(p.drive.run(move_by{3000 * pulse, gentle}));
        p.loop(300);
        if (how == 0) REQUIRE(p.drive.run(halt{}));
        if (how == 1) REQUIRE(p.drive.run(quick_stop{}));
        if (is_alarm) p.a.model.raise_alarm(2);
        if (how == 3) REQUIRE(p.drive.run(disable{}));
        p.loop(1000);
        const arrival a = p.drive.arrival();
        CHECK(a.how == arrival_state::stopped_short);
        CHECK(a.cause == (is_alarm ? stop_cause::fault : stop_cause::command));
        CHECK(a.missing.count() == 3000 - p.drive.feedback(milliseconds(2000))->position.count());
        const errc waited = p.drive.run(wait_reached{}).error();
        CHECK(waited == (is_alarm ? errc::faulted : errc::stopped_short));
        CHECK_FALSE(p.drive.run(wait_standstill{}));
    }
}

TEST_CASE_TEMPLATE(
    "G34, G35: as soon as an alarm shows, the move that it cuts has ended short, although the motor "
    "still turns",
    A, closed_axis, open_axis) {
    for (const auto alarm : {sim::yako_alarm::releases, sim::yako_alarm::holds}) {
        polled<A> p{{.alarm = alarm}};
        REQUIRE(p.drive.run(move_by{3000 * pulse, gentle}));
        p.loop(300);
        REQUIRE(p.drive.arrival().how == arrival_state::under_way);
        p.a.model.raise_alarm(2);
        while (p.drive.cause() != stop_cause::fault) p.loop(1);
        CHECK(p.drive.arrival().how == arrival_state::stopped_short);
        CHECK(p.drive.arrival().cause == stop_cause::fault);
    }
}

TEST_CASE("G34: a move that has stopped short stays so for minutes") {
    polled<closed_axis> p;
    REQUIRE(p.drive.run(move_by{50'000 * pulse, brisk}));
    p.loop(100);
    REQUIRE(p.drive.run(halt{}));
    for (int i = 0; i < 1300; ++i) { // 130 s
        p.loop(100);
        REQUIRE(p.drive.arrival().how == arrival_state::stopped_short);
    }
    for (int i = 0; i < 600; ++i) { // 100 minutes: the clock wraps after 71.6
        CAPTURE(i);
        p.a.wire.pass(milliseconds(10'000));
        REQUIRE(p.drive.read());
        REQUIRE(p.drive.arrival().how == arrival_state::stopped_short);
    }
}

TEST_CASE_TEMPLATE("G34: after a restart nothing is known of the move before it", A, closed_axis, open_axis) {
    polled<A> p;
    REQUIRE(p.drive.run(move_by{3000 * pulse, brisk}, wait_reached{}).how == arrival_state::reached);
    p.a.model.power_cycle();
    p.loop(600);
    REQUIRE(p.drive.state() == drive_state::needs_init);
    CHECK(p.drive.arrival().how == arrival_state::none);
    REQUIRE(p.drive.run(init{}));
    REQUIRE(p.drive.read());
    CHECK(p.drive.arrival().how == arrival_state::none);
    CHECK(p.drive.run(wait_reached{}).error() == errc::wrong_state);
}

namespace {
/// A command of a program's own: a move of which the library is not told where it ends.
struct move_somewhere {
    distance way;
    constexpr prepared_command prepare(const cached_settings& cached) const {
        prepared_command o = commands::prepared(move_by{way, brisk}, cached);
        o.has_target = false;
        return o;
    }
};
} // namespace

TEST_CASE("G34: a move without a stated target has no arrival") {
    polled<closed_axis> p;
    REQUIRE(p.drive.run(move_somewhere{3000 * pulse}));
    p.loop(2000);
    CHECK(p.a.place() == 3000);
    CHECK(p.drive.motion() == motion_check::seen);
    CHECK(p.drive.arrival().how == arrival_state::none);
    CHECK(p.drive.run(wait_reached{}).error() == errc::wrong_state);
}

TEST_CASE("S4: a motor that something else turns after an init is not taken for the bounded jog before it") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(bounded_jog{5000 * pulse, gentle}));
    REQUIRE(a.drive.run(init{}));
    const std::uint8_t start_jog[] = {0x00, 0x02};
    REQUIRE(a.model.write(motion_command.address, words_view{start_jog}) == 0);
    a.run(200);
    REQUIRE(a.is_moving());
    CHECK(a.drive.run(bounded_jog{5000 * pulse, gentle}).error() == errc::busy);
}

TEST_CASE("4.1: a move does not interrupt a motor that the program has not started") {
    closed_axis a;
    take(a);
    const std::uint8_t start_jog[] = {0x00, 0x02};
    REQUIRE(a.model.write(motion_command.address, words_view{start_jog}) == 0);
    a.run(200);
    REQUIRE(a.is_moving());
    CHECK(a.drive.run(move_by{100 * pulse, brisk, while_moving::interrupt}).error() == errc::busy);
    CHECK(a.model.starts() == 1);
}

TEST_CASE_TEMPLATE("G35: an alarm shows in the state within a feedback period and two frames, and ends the "
                   "command under way",
                   A, closed_axis, open_axis) {
    for (const auto alarm : {sim::yako_alarm::releases, sim::yako_alarm::holds}) {
        for (const bool is_idle : {false, true}) {
            polled<A> p{{.alarm = alarm}};
            REQUIRE(p.drive.run(velocity{60 * r_per_min}));
            p.loop(200);
            if (!is_idle) REQUIRE(p.drive.begin(wait_standstill{}) == errc::ok);
            p.a.model.raise_alarm(2);
            p.loop(20 + 2 * 10);
            CHECK(p.drive.state() == drive_state::faulted);
            CHECK(p.drive.cause() == stop_cause::fault);
            p.loop(3000); // it coasts
            if (!is_idle) CHECK(p.drive.last().error() == errc::faulted);
            CHECK(p.drive.run(move_by{100 * pulse, brisk}).error() == errc::faulted);
            CHECK_FALSE(p.a.is_moving());
            p.a.model.end_alarm();
            REQUIRE(p.drive.run(fault_reset{}));
            CHECK(p.drive.state() != drive_state::faulted);
        }
    }
}

TEST_CASE("G20: a command timeout stops a jog, and cuts neither a move nor a homing") {
    polled<closed_axis> p{{}, {.command_timeout = milliseconds(300)}};
    p.a.model.attach(simulated::yako_slide());
    REQUIRE(p.drive.run(velocity{60 * r_per_min}));
    p.loop(250);
    CHECK(p.a.is_moving());
    p.loop(400);
    CHECK_FALSE(p.a.is_moving());
    REQUIRE(p.drive.run(move_by{1000 * pulse, gentle}));
    p.loop(600);
    CHECK(p.a.is_moving());
    p.loop(2000);
    CHECK(p.drive.arrival().how == arrival_state::reached);
    REQUIRE(p.drive.begin(closed_loop::home{homing::home_24}) == errc::ok);
    while (!p.drive.is_idle()) p.loop(1);
    CHECK(p.drive.last());
    CHECK(p.drive.cached().is_homed);
}

TEST_CASE("a polled drive sends nothing but reads that the program did not command") {
    polled<open_axis> p;
    p.a.requests.clear();
    p.loop(1000);
    CHECK(p.a.requests.size() >= 45);
    CHECK(p.a.requests.size() <= 53); // the feedback, and the marker twice
    for (const auto& f : p.a.requests) CHECK(f[1] == 0x03);
}

TEST_CASE("an open loop motor that an input frees loses its position, and the state says that it is free") {
    polled<open_axis> p;
    REQUIRE(p.drive.run(disable{}));
    REQUIRE(p.drive.run(set_input{input_terminal::x3, input_function::motor_free}));
    REQUIRE(p.drive.run(enable{}));
    REQUIRE(p.drive.run(declare_position{0 * pulse}));
    p.a.model.set_input(3, true);
    p.loop(50);
    CHECK(p.drive.state() == drive_state::disabled);
    p.a.model.set_input(3, false);
    p.loop(50);
    CHECK(p.drive.state() == drive_state::enabled);
    CHECK(p.drive.run(move_to{0 * pulse, brisk}).error() == errc::needs_homing);
}

TEST_CASE("G34: a homing rests between two legs, also where the time since the start goes back") {
    cached_settings known{};
    known.state = drive_state::enabled;
    const prepared_command c = closed_loop::home{homing::home_24}.prepare(known);
    std::uint16_t words[8]{};
    motion_under_way<closed_loop::device> m;
    m.begin(c, words, known);
    words[1] = 0x0004; // moving
    REQUIRE(m.status_of(words).is_moving());
    CHECK(m.confirm_home(c, words, milliseconds(119'990), known) == errc::busy);
    words[1] = 0;
    CHECK(m.confirm_home(c, words, milliseconds(60'000), known) == errc::busy);
    CHECK(m.confirm_home(c, words, milliseconds(60'499), known) == errc::busy);
    CHECK(m.confirm_home(c, words, milliseconds(60'500), known) == errc::not_reached);
}

TEST_CASE("G34: a limit input that is active is the cause of a stop, also beyond a software limit") {
    using enum input_function;
    constexpr std::uint16_t beyond = motion_status::positive_limit_bit;
    struct scene {
        std::uint16_t status, inputs;
        stop_cause cause;
    };
    for (const scene& s : {scene{beyond, 0, stop_cause::software_limit},
                           {beyond, 1, stop_cause::input},
                           {0, 1, stop_cause::input},
                           {0, 0, stop_cause::unknown}}) {
        CAPTURE(s.status);
        CAPTURE(s.inputs);
        const std::uint16_t words[11]{0, s.status, s.inputs, 0, 0, 0, 0, static_cast<u16>(positive_limit)};
        motion_under_way<closed_loop::device> m;
        m.examine(words);
        CHECK(m.cause() == s.cause);
    }
}

TEST_CASE("G34: a move that a command has cut was stopped by that, though a limit switch is active") {
    closed_axis a;
    take(a);
    REQUIRE(a.drive.run(move_by{50'000 * pulse, brisk}));
    REQUIRE(a.drive.run(halt{}));
    a.model.set_input(1, true); // X1 is the positive limit from the factory
    a.wire.pass(milliseconds(50));
    CHECK(a.drive.run(wait_reached{}).error() == errc::stopped_short);
    CHECK(a.drive.arrival().how == arrival_state::stopped_short);
    CHECK(a.drive.arrival().cause == stop_cause::command);
}

TEST_CASE("G34: a place is no end of the counter's range to a move that goes back from it") {
    cached_settings known{};
    known.state = drive_state::enabled;
    known.is_homed = true;
    known.has_scale = known.has_profile = true;
    known.word_order = word_order::high_first;
    const prepared_command c = commands::prepared(move_to{1000 * pulse, brisk}, known);
    REQUIRE(c.refusal == errc::ok);
    std::uint16_t words[8]{};
    words[routines::position_at] = 0x7FFF;
    words[routines::position_at + 1] = 0xFFFF;
    motion_under_way<closed_loop::device> m;
    m.begin(c, words, known);
    m.keep_goal(c);
    CHECK(m.arrival_of(words, milliseconds(100), known).how == arrival_state::under_way);
    CHECK(m.arrival_of(words, milliseconds(300), known).how == arrival_state::stopped_short);
}

} // namespace arrival_yako_tests
