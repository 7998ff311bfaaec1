// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// C630S: a motor that turns while a command is repeated: the command timeout stops it when the program repeats no more,
// and nothing when the line is lost, as the command says by name.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/enabled_c630s.hpp>

namespace hold_c630s_tests {

using namespace enabled_c630s;
using namespace servobus::units;

namespace {

constexpr held_velocity at_300{300 * r_per_min, runs_on_without_line{}};

struct rig : simulated::driven_c630s {
    explicit rig(command_timeout limit = milliseconds(300), std::uint64_t seed = 1) : driven_c630s{{}, seed} {
        be_enabled_in(*this, control_mode::speed);
        drive.set_command_timeout(limit);
    }
    unsigned repeat(const held_velocity& wanted, duration every, std::uint32_t ms) {
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
};

} // namespace

TEST_CASE("a servo turns while the command is repeated, turns round, and halt releases it") {
    for (const std::uint32_t every : {10u, 20u, 50u, 100u}) {
        rig r;
        CHECK(r.repeat(at_300, milliseconds(every), 2000) == 0);
        CHECK(r.r_per_min() == 300);
        CHECK(r.repeat({-300 * r_per_min, runs_on_without_line{}}, milliseconds(every), 2000) == 0);
        CHECK(r.r_per_min() == -300);
        r.loop(50); // the last one ends
        REQUIRE(r.drive.run(halt{}));
        r.loop(1000);
        CHECK(r.r_per_min() == 0);
        CHECK(r.model.enabled());
    }
}

TEST_CASE("G20: a program that steps and does not repeat: the servo stops after the command timeout") {
    for (std::uint32_t ms = 1000; ms < 1060; ms += 7) {
        rig r;
        CHECK(r.repeat(at_300, milliseconds(50), ms) == 0);
        CHECK(r.r_per_min() == 300);
        const std::uint64_t from = r.wire.time_us();
        while (r.r_per_min() != 0 && r.wire.time_us() < from + 10'000'000) r.loop(5);
        CHECK(r.wire.time_us() - from <= 300'000 + 700'000);
        r.loop(2000);
        CHECK(r.r_per_min() == 0);
        CHECK(r.drive.state() == drive_state::enabled);
    }
}

TEST_CASE(
    "without the line, or without steps, the servo turns on, until the program is there again and stops it") {
    for (const bool is_line_lost : {false, true}) {
        rig r;
        CHECK(r.repeat(at_300, milliseconds(50), 1000) == 0);
        const std::uint32_t struck = r.wire.struck();
        r.wire.faults().lost_request = is_line_lost ? 1000 : 0;
        if (is_line_lost) r.loop(10'000);
        if (!is_line_lost) r.wire.pass(milliseconds(10'000));
        CHECK((r.wire.struck() > struck + 2) == is_line_lost);
        CHECK(r.r_per_min() == 300);
        r.wire.faults() = {};
        r.loop(3000); // the stop of the command timeout is repeated until it is confirmed
        CHECK(r.r_per_min() == 0);
    }
}

TEST_CASE("G21: a response that is lost is made up for by a read-back; a restart ends it") {
    std::uint32_t struck = 0;
    unsigned failures = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        rig r{milliseconds(800), seed};
        const std::uint32_t before = r.wire.struck();
        r.wire.faults().lost_response = 20;
        failures += r.repeat(at_300, milliseconds(50), 3000);
        r.wire.faults() = {};
        struck += r.wire.struck() - before;
    }
    CHECK(struck > 20);
    CHECK(failures == 0);
    rig r;
    CHECK(r.repeat(at_300, milliseconds(50), 1000) == 0);
    r.model.power_cycle();
    CHECK(r.repeat(at_300, milliseconds(50), 2000) != 0);
    CHECK(r.r_per_min() == 0);
    CHECK_FALSE(r.model.enabled());
}

TEST_CASE("it is refused without a command timeout, and where velocity is") {
    rig r{no_command_timeout};
    const std::size_t frames = r.requests.size();
    CHECK(r.drive.begin(at_300) == errc::bad_argument);
    CHECK(r.drive.run(at_300).error() == errc::bad_argument);
    CHECK(r.drive.run(hold{6001 * r_per_min, runs_on_without_line{}}).error() == errc::out_of_range);
    CHECK(r.requests.size() == frames);
    r.drive.set_command_timeout(milliseconds(300));
    CHECK(r.drive.run(at_300));
    REQUIRE(r.drive.run(disable{}));
    CHECK(r.drive.run(at_300).error() == errc::wrong_state);
}

} // namespace hold_c630s_tests
