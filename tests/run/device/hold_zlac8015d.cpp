// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// ZLAC8015D: wheels that turn while a command is repeated: what stops them when the program, the line or the drive ends
// the repetition, by the simulator's own wheels.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/device/zlac8015d/arguments.hpp>

#include <tests/support/enabled_zlac8015d.hpp>

namespace hold_zlac8015d_tests {

using namespace enabled_zlac8015d;
using namespace servobus::units;

namespace {

constexpr held_velocities straight{60 * r_per_min, -60 * r_per_min};
constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(200)};

struct rig : simulated::driven_zlac8015d {
    explicit rig(const supervision& by = supervised, std::uint64_t seed = 1)
        : driven_zlac8015d{{}, by, seed} {
        be_enabled_in(*this, operating_mode::velocity);
    }
    void step_for(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + 1000 * std::uint64_t{ms};
        while (wire.time_us() < end) turn();
    }
    void turn() {
        const duration idle = drive.step();
        wire.wait(idle.us == 0 ? microseconds(10) : idle);
    }
    /// Repeats the command; returns how many have failed.
    unsigned repeat(const held_velocities& wanted, duration every, std::uint32_t ms) {
        unsigned failures = 0;
        const std::uint64_t end = wire.time_us() + 1000 * std::uint64_t{ms};
        std::uint64_t due = wire.time_us();
        bool is_under_way = false;
        while (wire.time_us() < end) {
            if (drive.is_idle()) {
                if (is_under_way && !drive.last()) ++failures;
                is_under_way = false;
                if (wire.time_us() >= due) {
                    due = wire.time_us() + every.us;
                    is_under_way = drive.begin(wanted) == errc::ok;
                    failures += is_under_way ? 0 : 1;
                }
            }
            turn();
        }
        return failures;
    }
    bool turns() const { return !model.stands_still(); }
    /// How long the wheels turn on; at most ten seconds.
    template <class Pass> std::uint32_t turning_on(Pass pass) {
        const std::uint64_t from = wire.time_us();
        while (turns() && wire.time_us() < from + 10'000'000) pass();
        return static_cast<std::uint32_t>((wire.time_us() - from) / 1000);
    }
};

} // namespace

TEST_CASE("the wheels turn while the command is repeated, and halt releases them") {
    for (const std::uint32_t every : {10u, 20u, 50u, 100u}) {
        rig r;
        CHECK(r.repeat(straight, milliseconds(every), 3000) == 0);
        CHECK(r.model.left().speed > 59'000'000);
        CHECK(r.model.right().speed < -59'000'000);
        const auto stops = r.sent(simulated::zero_targets);
        r.step_for(50); // the last one ends
        REQUIRE(r.drive.run(halt{}));
        CHECK(r.sent(simulated::zero_targets) > stops);
        CHECK(r.turning_on([&] { r.step_for(5); }) <= 700); // the drive's ramp, 500 ms
    }
}

TEST_CASE("another direction is taken over while the wheels turn") {
    rig r;
    CHECK(r.repeat(straight, milliseconds(50), 1500) == 0);
    CHECK(r.repeat({-60 * r_per_min, 60 * r_per_min}, milliseconds(50), 2500) == 0);
    CHECK(r.model.left().speed < -59'000'000);
    CHECK(r.model.right().speed > 59'000'000);
}

TEST_CASE("G20: a program that steps and does not repeat: the wheels stop after the command timeout") {
    for (std::uint32_t ms = 1000; ms < 1060; ms += 3) {
        rig r;
        CHECK(r.repeat(straight, milliseconds(50), ms) == 0);
        REQUIRE(r.turns());
        // 200 ms, the setpoint under way, and the drive's ramp.
        CHECK(r.turning_on([&] { r.step_for(5); }) <= 200 + 20 + 700);
        CHECK(r.drive.state() == drive_state::enabled);
        CHECK_FALSE(r.model.in_watchdog_stop());
        r.step_for(2000);
        CHECK_FALSE(r.turns());
    }
}

TEST_CASE("G20: a program that stops stepping: the drive's watchdog stops the wheels") {
    for (std::uint32_t ms = 1000; ms < 1060; ms += 3) {
        rig r;
        CHECK(r.repeat(straight, milliseconds(50), ms) == 0);
        REQUIRE(r.turns());
        CHECK(r.turning_on([&] { r.wire.pass(milliseconds(5)); }) <= 1000 + 700);
        CHECK(r.model.in_watchdog_stop());
        r.step_for(3000); // the program goes on, and repeats no more
        CHECK_FALSE(r.turns());
        CHECK(r.drive.begin(straight) == errc::needs_init);
    }
}

TEST_CASE("G20, G21: when the line is lost the drive's watchdog stops the wheels, also of a program that "
          "goes on to repeat") {
    for (const bool goes_on : {false, true}) {
        rig r;
        CHECK(r.repeat(straight, milliseconds(50), 1000) == 0);
        r.wire.faults().lost_request = 1000;
        const std::uint32_t struck = r.wire.struck();
        const std::uint64_t from = r.wire.time_us();
        while (r.turns() && r.wire.time_us() < from + 10'000'000) {
            if (goes_on && r.drive.is_idle()) (void)r.drive.begin(straight);
            r.step_for(5);
        }
        CHECK(r.wire.time_us() - from <= 1'700'000);
        CHECK(r.wire.struck() > struck + 2);
        r.wire.faults() = {};
        for (int i = 0; i < 400; ++i) {
            if (goes_on && r.drive.is_idle()) (void)r.drive.begin(straight);
            r.step_for(5);
        }
        CHECK_FALSE(r.turns());
        CHECK(r.drive.state() == drive_state::needs_init);
    }
}

TEST_CASE("G21: a response that is lost is made up for by a read-back, and the wheels turn on") {
    std::uint32_t struck = 0;
    unsigned failures = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        rig r{supervised, seed};
        const std::uint32_t before = r.wire.struck();
        r.wire.faults().lost_response = 20;
        failures += r.repeat(straight, milliseconds(50), 3000);
        r.wire.faults() = {};
        struck += r.wire.struck() - before;
        CHECK(r.turns() == (r.drive.state() == drive_state::enabled));
    }
    CHECK(struck > 20);
    CHECK(failures == 0);
}

TEST_CASE("G21: a restart ends it, and nothing turns after it") {
    rig r;
    CHECK(r.repeat(straight, milliseconds(50), 1000) == 0);
    r.model.power_cycle();
    CHECK(r.repeat(straight, milliseconds(50), 3000) != 0);
    CHECK_FALSE(r.turns());
    CHECK(r.drive.state() == drive_state::needs_init);
}

TEST_CASE("it is refused where nothing would stop the wheels") {
    SUBCASE("no command timeout") {
        rig r{unsupervised};
        const auto frames = r.log.frames.size();
        CHECK(r.drive.begin(straight) == errc::bad_argument);
        CHECK(r.drive.run(straight).error() == errc::bad_argument);
        CHECK(why(r.drive, straight).error == errc::ok); // the plan has no objection
        CHECK(r.log.frames.size() == frames);
        r.drive.set_command_timeout(milliseconds(300));
        CHECK(r.drive.run(straight));
        CHECK(r.turning_on([&] { r.step_for(5); }) <= 300 + 700);
        while (!r.drive.is_idle()) r.turn(); // its stop
        r.drive.set_command_timeout(no_command_timeout);
        CHECK(r.drive.run(straight).error() == errc::bad_argument);
        CHECK(r.drive.run(velocity{60 * r_per_min, 60 * r_per_min}).error() ==
              errc::ok); // which asks for none
    }
    SUBCASE("no watchdog") {
        rig r;
        REQUIRE(r.drive.run(disable{}));
        REQUIRE(r.drive.run(watchdog{undocumented_zero{}}));
        REQUIRE(r.drive.run(enable{}));
        CHECK(r.drive.run(straight).error() == errc::wrong_state);
        const refusal because = why(r.drive, straight);
        REQUIRE(because.unmet() != nullptr);
        CHECK(because.unmet()->address == host_timeout.address);
        CHECK(because.unmet()->is_flag);
    }
    SUBCASE("another mode, too fast") {
        rig r;
        CHECK(r.drive.run(hold{3001 * r_per_min, 0 * r_per_min}).error() == errc::out_of_range);
        REQUIRE(r.drive.run(disable{}));
        CHECK(r.drive.run(straight).error() == errc::wrong_state);
    }
}

} // namespace hold_zlac8015d_tests
