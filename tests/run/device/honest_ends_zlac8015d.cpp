// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a ZLAC8015D's commands must end when the drive does not execute them: a fault, a wired stop, a move of
// one wheel. For each scene one test shows what the simulated drive does, and one what the facade reports.
#include <string>

#include <doctest/doctest.h>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace honest_ends_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;
using sim_options = sim::zlac8015d_options;

namespace {

using tests::wheels_node;

constexpr duration feedback_period = milliseconds(20);
constexpr supervision supervised{.feedback = feedback_period, .command_timeout = milliseconds(300)};
constexpr poll_plan plan{modbus::timing_at(115200), controlled(wheels_node, supervised),
                         cyclic<bus_voltage>(wheels_node, feedback_period)};

enum class event { fault, input };
enum class stepper { program, bus };

/// A program that commands speeds every 20 ms; it steps the facade, or a bus does.
struct scene {
    using line_type = scheduled_line<sim::virtual_line>;
    sim::zlac8015d model;
    sim::station<sim::zlac8015d> station{model};
    sim::virtual_line wire{115200};
    line_type on{wire, modbus::timing_at(115200)};
    zlac8015d::drive<line_type> wheels{on, wheels_node, supervised};
    bus<plan, line_type, decltype(wheels)> all{on, wheels};
    bool has_bus;

    explicit scene(stepper who, const sim_options& interpretations = {})
        : model{interpretations}, has_bus{who == stepper::bus} {
        wire.attach(station);
        command(init{});
        command(ramps{100 * millisecond, 100 * millisecond});
        command(enable_in{operating_mode::velocity});
    }
    void turn() {
        const duration idle = has_bus ? all.step() : wheels.step();
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
    template <class Wanted> void command(const Wanted& wanted) {
        REQUIRE(wheels.begin(wanted) == errc::ok);
        while (!wheels.is_idle()) turn();
        REQUIRE(wheels.last());
    }
    /// True if the command was reported as done. Returns 20 ms after it began.
    bool commands_speed() {
        const std::uint64_t next = wire.time_us() + 20'000;
        const bool began = wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok;
        while (!wheels.is_idle()) turn();
        while (wire.time_us() < next) turn();
        return began && wheels.last();
    }
    void happens(event what) {
        for (int i = 0; i < 50; ++i) REQUIRE(commands_speed());
        REQUIRE_FALSE(model.stands_still());
        if (what == event::fault) {
            model.raise(fault::overcurrent, fault::none);
            model.end_faults(); // the fault stays latched until 06h
        } else {
            model.set_input(true, false);
        }
    }
    /// How many of 200 commands, in 4 s, are reported as done.
    unsigned carried_out() {
        unsigned n = 0;
        for (int i = 0; i < 200; ++i) n += commands_speed() ? 1u : 0u;
        return n;
    }
    /// True if the commands and the state show the event 40 ms later, which is a feedback period and more
    /// than two frames.
    bool shows_it(event what) {
        happens(what);
        (void)commands_speed();
        (void)commands_speed();
        return !commands_speed() && wheels.state() != drive_state::enabled;
    }
};

/// A move of 40960 pulses that the wired stop ends early.
struct short_move : simulated::driven_zlac8015d {
    short_move() {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable_in{operating_mode::relative_position}));
        REQUIRE(drive.run(move_by{40960 * pulse, 40960 * pulse}));
        wire.pass(milliseconds(345));
        model.set_input(true, false);
    }
};

/// Asynchronous mode, 3.2, in which each wheel is started by itself: the left wheel moves.
struct left_moves : simulated::driven_zlac8015d {
    left_moves() {
        REQUIRE(drive.run(init{}));
        REQUIRE(drive.run(enable_in{operating_mode::relative_position, synchronisation::asynchronous}));
        REQUIRE(drive.run(move_left_by{40960 * pulse}));
        wire.pass(milliseconds(300));
        REQUIRE_FALSE(model.stands_still());
    }
};

} // namespace

TEST_CASE(
    "set-up: a fault or the wired stop disables the drive while a program continues to command speeds") {
    for (const stepper who : {stepper::program, stepper::bus}) {
        for (const event what : {event::fault, event::input}) {
            scene s{who};
            s.happens(what);
            const unsigned n = s.carried_out();
            CHECK(s.model.stands_still());
            CHECK_FALSE(s.model.enabled());
            CHECK(s.model.enables() == 1);
            const auto seen = s.wheels.feedback(milliseconds(100));
            REQUIRE(seen);
            const auto shaft = seen->state.left.shaft;
            CHECK(shaft == (what == event::fault ? shaft_state::alarm : shaft_state::emergency_stop));
            CHECK(seen->left_faults.any() == (what == event::fault));
            if (who == stepper::bus) CHECK(s.all.latest<bus_voltage>(wheels_node, milliseconds(100)));
            MESSAGE(std::string{what == event::fault ? "fault" : "wired stop"},
                    std::string{who == stepper::bus ? ", bus: " : ": "}, n,
                    " of 200 speeds reported as done, state ", static_cast<int>(s.wheels.state()));
        }
    }
}

TEST_CASE("G35: a fault shows in the commands and in the state within a feedback period") {
    CHECK(scene{stepper::program}.shows_it(event::fault));
}

TEST_CASE("G35: on a bus, a fault shows in the commands and in the state within a feedback period") {
    CHECK(scene{stepper::bus}.shows_it(event::fault));
}

TEST_CASE("G35: a wired stop shows in the commands and in the state within a feedback period") {
    CHECK(scene{stepper::program}.shows_it(event::input));
}

TEST_CASE("G35: on a bus, a wired stop shows in the commands and in the state within a feedback period") {
    CHECK(scene{stepper::bus}.shows_it(event::input));
}

TEST_CASE("set-up: if a fault stops only its own wheel, the other one continues to turn") {
    for (const stepper who : {stepper::program, stepper::bus}) {
        scene s{who, {.by_fault = sim_options::switched_off::its_wheel}};
        s.happens(event::fault);
        CHECK(s.model.peek(left_faults.address) != 0);
        CHECK(s.model.peek(right_faults.address) == 0);
        const std::int64_t before = s.model.right().position;
        (void)s.carried_out();
        MESSAGE("left wheel faulted: the right one moved on by ", s.model.right().position - before,
                " counts");
    }
}

TEST_CASE("a fault of one wheel stops both while speeds are commanded") {
    scene s{stepper::program, {.by_fault = sim_options::switched_off::its_wheel}};
    s.happens(event::fault);
    (void)s.carried_out();
    CHECK(s.model.stands_still());
}

TEST_CASE("a fault of one wheel that the bus has read stops both") {
    scene s{stepper::bus, {.by_fault = sim_options::switched_off::its_wheel}};
    s.happens(event::fault);
    (void)s.carried_out();
    CHECK(s.model.stands_still());
}

// A command that changes the drive's settings, and a stop, read the feedback too.
TEST_CASE("G35: a wired stop that an enable has read shows in the state when it has ended") {
    simulated::driven_zlac8015d r; // it polls nothing
    REQUIRE(r.drive.run(init{}));
    REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
    REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
    REQUIRE(r.live(milliseconds(1000)));
    r.model.set_input(true, false);
    CHECK(r.drive.run(enable_in{operating_mode::torque}).error() == errc::busy);
    CHECK(r.drive.state() == drive_state::quick_stopped);
    CHECK(r.drive.cause() == stop_cause::input);
}

// The speed that was under way when the feedback showed the stop is acknowledged, and ends as done.
TEST_CASE("a wired stop stays the cause while speeds are commanded, at whatever moment it comes") {
    unsigned acknowledged = 0;
    for (const auto who : {stepper::program, stepper::bus}) {
        for (std::uint64_t us = 0; us < 20'000; us += 500) {
            scene s{who};
            for (int i = 0; i < 20; ++i) REQUIRE(s.commands_speed());
            const std::uint64_t pressed = s.wire.time_us() + us;
            bool was_held = false;
            for (int i = 0; i < 40; ++i) {
                const bool is_held = s.wheels.state() == drive_state::quick_stopped;
                const bool began = s.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok;
                const std::uint64_t next = s.wire.time_us() + 20'000;
                while (s.wire.time_us() < next) {
                    if (s.wire.time_us() >= pressed) s.model.set_input(true, false);
                    s.turn();
                    was_held = was_held || s.wheels.state() == drive_state::quick_stopped;
                    if (was_held) REQUIRE(s.wheels.cause() == stop_cause::input);
                }
                acknowledged += began && !is_held && was_held && s.wheels.last() ? 1u : 0u;
            }
            CHECK(was_held);
        }
    }
    CHECK(acknowledged > 5);
}

TEST_CASE("a fault of one wheel stops both if an enable or a halt has read it first") {
    for (const bool is_halt : {false, true}) {
        simulated::driven_zlac8015d r{{.by_fault = sim_options::switched_off::its_wheel},
                                      {.feedback = feedback_period, .command_timeout = no_command_timeout}};
        REQUIRE(r.drive.run(init{}));
        REQUIRE(r.drive.run(enable_in{operating_mode::velocity}));
        REQUIRE(r.drive.run(velocity{100 * r_per_min, 100 * r_per_min}));
        REQUIRE(r.live(milliseconds(1000)));
        r.model.raise(fault::overcurrent, fault::none);
        const command_status ended =
            is_halt ? r.drive.run(halt{}) : r.drive.run(enable_in{operating_mode::torque});
        CHECK(static_cast<bool>(ended) == is_halt);
        const auto stop = servobus::modbus::write_frame(1, control_word.address, 7);
        const std::uint64_t end = r.wire.time_us() + 1'000'000;
        while (r.wire.time_us() < end) {
            const duration idle = r.drive.step();
            r.wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        CHECK(r.model.stands_still());
        CHECK_FALSE(r.model.enabled());
        CHECK(r.sent(stop) >= 2); // of init, and of the fault
        CHECK(r.drive.state() == drive_state::faulted);
        CHECK(r.drive.cause() == stop_cause::fault);
    }
}

TEST_CASE("set-up: the wired stop interrupts a move of 40960 pulses") {
    short_move m;
    (void)m.drive.run(wait_standstill{});
    CHECK(m.model.stands_still());
    CHECK(m.model.left().position > 1000);
    CHECK(m.model.left().position < 5000);
    CHECK(m.model.peek(status_word.address) == status_flags::both_stopped_in_emergency);
    MESSAGE("stopped at ", m.model.left().position,
            " of 40960 pulses, wait_standstill: ", std::string{m.drive.last() ? "ok" : "not ok"});
}

TEST_CASE("G34: a wait for the end of an interrupted move does not succeed") {
    short_move m;
    CHECK_FALSE(m.drive.run(wait_standstill{}));
}

TEST_CASE("set-up: the drive starts a wheel with 12h while the other one moves") {
    left_moves m;
    client direct{m.line, node<device>{1}};
    REQUIRE(direct.write<right_target_position>(20480));
    REQUIRE(direct.write<control_word>(control_code::start_right));
    CHECK(m.model.starts() == 2);
    while (!m.model.stands_still()) { // the facade's settings are stale
        REQUIRE(direct.read<status_word>());
        m.wire.pass(milliseconds(100));
    }
    CHECK(m.model.left().position == 40960);
    CHECK(m.model.right().position == 20480);
    MESSAGE("left ", m.model.left().position, ", right ", m.model.right().position, " pulses");
}

TEST_CASE("asynchronous mode: the right wheel is started while the left one moves") {
    left_moves m;
    CHECK(m.drive.run(move_right_by{20480 * pulse}));
}

} // namespace honest_ends_zlac8015d_tests
