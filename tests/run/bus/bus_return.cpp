// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives of a bus that stop responding and return: which request they get first, whether their drive state
// stays valid meanwhile, and that no motion resumes by itself.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>

namespace bus_return_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using frame = std::vector<std::uint8_t>;
using program = tests::wheels_and_lift_program;
constexpr auto zero_speeds = modbus::write_frame(1, 0x2088, std::array<std::uint16_t, 2>{0, 0});
constexpr auto disable_frame = modbus::write_frame(1, 0x200E, 7);

struct rig : tests::wheels_and_lift {
    program p{wire};
    std::vector<frame> requests; // to the wheels
    frame open;
    std::uint64_t heard_at = 0;
    std::uint64_t longest_gap = 0;

    rig() { wire.set_hook(&rig::note, this); }

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<rig*>(self);
        r.open.push_back(b.value);
        if (r.open.size() != modbus::request_length(r.open)) return;
        if (r.open[0] == 1) {
            r.requests.push_back(r.open);
            if (r.heard_at != 0 && b.at_us - r.heard_at > r.longest_gap) r.longest_gap = b.at_us - r.heard_at;
            r.heard_at = b.at_us;
        }
        r.open.clear();
    }
    void turn() { p.turn(); }
    void loop(std::uint32_t ms) { p.run(ms); }
    template <class Drive, class Wanted> command_status command(Drive& drive, const Wanted& wanted) {
        return p.command(drive, wanted);
    }
    /// The lift is at 300 pulses, and its position was read.
    void place_lift() {
        REQUIRE(command(p.lift, init{}));
        REQUIRE(command(p.lift, enable{}));
        REQUIRE(command(p.lift, declare_position{300 * pulse}));
        loop(500);
        REQUIRE(*p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(200)) == 300 * pulse);
    }
    void drive_wheels() {
        REQUIRE(command(p.wheels, init{}));
        REQUIRE(command(p.lift, init{}));
        REQUIRE(command(p.wheels, zlac8015d::watchdog{1000 * millisecond}));
        REQUIRE(command(p.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        REQUIRE(command(p.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
        loop(1000);
        REQUIRE_FALSE(wheels_model.stands_still());
    }
};

bool may_be_first(const frame& f) { return same_bytes(f, zero_speeds) || same_bytes(f, disable_frame); }

} // namespace

TEST_CASE(
    "G26: a stop stays open after a later command without a response, and a command that succeeds ends it") {
    rig r;
    REQUIRE(r.command(r.p.lift, init{}));
    REQUIRE(r.command(r.p.lift, enable{}));
    REQUIRE(r.command(r.p.lift, velocity{30 * r_per_min}));
    r.wire.set_connected(1, false);
    REQUIRE_FALSE(r.command(r.p.lift, quick_stop{}));
    command_status taken_over;
    tests::loop_bound left{"a drive that takes a command"};
    do {
        left.use();
        r.turn();
        taken_over = r.command(r.p.lift, init{});
    } while (taken_over.error() == errc::busy);
    CHECK_FALSE(taken_over);
    r.loop(2000);
    CHECK(r.lift_model.view().is_moving);
    r.wire.set_connected(1, true);
    r.loop(3000);
    CHECK_FALSE(r.lift_model.view().is_moving);
    REQUIRE(r.command(r.p.lift, init{}));
    REQUIRE(r.command(r.p.lift, enable{}));
    REQUIRE(r.command(r.p.lift, velocity{30 * r_per_min}));
    r.loop(3000);
    CHECK(r.lift_model.view().is_moving); // the stop is not repeated any more
}

TEST_CASE(
    "S3, G20, G21: wheels that stopped because the line was lost are sent nothing but stops until an init") {
    for (const std::uint32_t limit_ms : {0u, 400u, 60'000u}) {
        for (unsigned ms = 3000; ms < 4100; ms += 50) {
            CAPTURE(limit_ms);
            CAPTURE(ms);
            rig r;
            r.drive_wheels();
            if (limit_ms != 0) r.p.wheels.set_command_timeout(milliseconds(limit_ms));
            r.wire.set_connected(0, false);
            r.loop(ms);
            REQUIRE(r.wheels_model.in_watchdog_stop());
            CHECK(r.p.wheels.state() == zlac8015d::drive_state::needs_init);
            CHECK(r.p.all.is_absent(1));
            CHECK_FALSE(r.p.all.is_absent(2));
            for (tests::loop_bound left{"a free line"}; !r.p.on.is_free(); left.use()) r.turn();
            const auto place = r.wheels_model.left().position;
            r.requests.clear();
            r.wire.set_connected(0, true);
            r.loop(2500);
            CHECK((r.requests.empty() || may_be_first(r.requests[0]))); // the stop of the command timeout
            CHECK(r.wheels_model.left().position == place);
            CHECK(r.wheels_model.stands_still());
            CHECK(r.p.wheels.state() == zlac8015d::drive_state::needs_init);
            CHECK(r.p.wheels.feedback(milliseconds(60'000)).error() == errc::needs_init);
            r.requests.clear();
            REQUIRE(r.command(r.p.wheels, init{}));
            CHECK(may_be_first(r.requests.at(0)));
            r.loop(100);
            CHECK(r.p.wheels.feedback(milliseconds(60)));
            CHECK(r.wheels_model.left().position == place);
        }
    }
}

TEST_CASE("S3, G20: wheels that stopped because the program paused get a stop before they are read") {
    for (unsigned us = 0; us < 40'000; us += 700) {
        CAPTURE(us);
        rig r;
        r.drive_wheels();
        r.wire.pass(microseconds(us));
        for (unsigned i = us % 3; i != 0; --i) r.turn();
        r.wire.pass(milliseconds(4000));
        REQUIRE(r.wheels_model.in_watchdog_stop());
        const auto place = r.wheels_model.left().position;
        r.requests.clear();
        r.loop(1000);
        CHECK(r.requests.empty());
        CHECK(r.p.wheels.state() == zlac8015d::drive_state::needs_init);
        CHECK(r.command(r.p.wheels, init{}));
        CHECK(may_be_first(r.requests.at(0)));
        CHECK(r.wheels_model.left().position == place);
    }
}

TEST_CASE("S1, S3: wheels that a crashed program has left get a stop before the next program reads them") {
    rig r;
    r.drive_wheels();
    r.wire.pass(milliseconds(4000));
    REQUIRE(r.wheels_model.in_watchdog_stop());
    program next{r.wire};
    const auto place = r.wheels_model.left().position;
    r.requests.clear();
    next.run(1000);
    CHECK(r.requests.empty());
    REQUIRE(next.wheels.begin(init{}) == errc::ok);
    next.run(1000);
    CHECK(may_be_first(r.requests.at(0)));
    CHECK(r.wheels_model.left().position == place);
    CHECK(next.all.count(0) > 10);
    CHECK(next.wheels.state() == zlac8015d::drive_state::disabled);
}

TEST_CASE("G28: lost responses cost disabled wheels and the lift no further frames") {
    rig r;
    REQUIRE(r.command(r.p.wheels, init{}));
    REQUIRE(r.command(r.p.lift, init{}));
    r.loop(500);
    r.wire.faults().lost_response = 1000;
    const std::uint32_t reads = r.p.all.count(0);
    r.loop(160);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    REQUIRE(r.p.on.epoch(1).misses != 0);
    r.loop(500);
    REQUIRE(r.p.all.count(0) > reads);
    r.requests.clear();
    r.loop(1000);
    CHECK(r.requests.size() <= 71); // the image every 20 ms, a read every 50 ms
    CHECK(r.p.wheels.state() == zlac8015d::drive_state::disabled);
}

TEST_CASE("G28: absent wheels cost the lift nothing once their state is unknown, whether they have ever "
          "responded or not") {
    for (const bool were_there : {true, false}) {
        CAPTURE(were_there);
        rig r;
        if (were_there) r.drive_wheels();
        if (!were_there) { REQUIRE(r.command(r.p.lift, init{})); }
        r.wire.set_connected(0, false);
        r.loop(3000);
        const std::size_t asked = r.requests.size();
        const std::uint32_t reads = r.p.all.count(1);
        r.loop(10'000);
        CHECK(r.requests.size() == asked);
        CHECK(r.p.all.count(1) - reads >= 164); // every 60 ms
        r.wire.set_connected(0, true);
        CHECK(r.command(r.p.wheels, init{}));
    }
}

TEST_CASE(
    "G28: an absent lift costs the wheels one frame in the plan's retry period, and is found within it") {
    rig r;
    r.drive_wheels();
    r.wire.set_connected(1, false);
    r.loop(3000);
    const std::uint32_t asked = r.wire.requests();
    const std::size_t to_wheels = r.requests.size();
    r.loop(20'000);
    // Cyclic reads of the lift are retried every second, its feedback every two: two drives share that.
    CHECK(r.wire.requests() - asked - (r.requests.size() - to_wheels) <= 20 + 10 + 2);
    CHECK(r.wire.requests() - asked - (r.requests.size() - to_wheels) >= 20 + 8);
    r.wire.set_connected(1, true);
    const std::uint64_t back = r.wire.time_us();
    for (tests::loop_bound left{"an event"}; r.p.lift.is_absent(); left.use()) r.turn();
    CHECK(r.wire.time_us() - back <= tests::fast_plan.rediscovery_bound(2).us);
    r.loop(200);
    CHECK(r.p.lift.feedback(milliseconds(100)));
}

TEST_CASE("G19: wheels whose responses are lost get requests in time as long as their drive state is valid") {
    rig r;
    r.drive_wheels();
    r.wire.set_connected(1, false); // the lift is absent as well
    r.loop(3000);
    r.longest_gap = 0;
    r.wire.faults().lost_response = 1000;
    r.loop(600);
    CHECK(r.wire.struck() != 0);
    r.wire.faults() = {};
    r.loop(3000);
    CHECK(r.longest_gap < 500'000);
    CHECK_FALSE(r.wheels_model.in_watchdog_stop());
    CHECK(static_cast<std::int16_t>(r.wheels_model.peek(0x20AB)) == 300);
    CHECK(r.p.wheels.state() == zlac8015d::drive_state::enabled);
}

TEST_CASE("G21: responses to the reads of a bus keep the drive state valid, so that a rare command needs no "
          "initialisation") {
    rig r;
    r.drive_wheels();
    r.loop(10'000);
    CHECK(r.p.wheels.state() == zlac8015d::drive_state::enabled);
    CHECK(r.command(r.p.wheels, velocity{10 * r_per_min, 10 * r_per_min}));
}

TEST_CASE(
    "G21: a drive that did not respond for a while needs initialisation if it has restarted meanwhile, and "
    "only then") {
    for (const bool is_restarted : {false, true}) {
        CAPTURE(is_restarted);
        rig r;
        r.drive_wheels();
        r.wire.set_connected(1, false);
        r.loop(2000);
        CHECK(r.p.lift.current_word_order() == word_order::unknown);
        CHECK(r.p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(60'000)).error() ==
              errc::needs_word_order);
        if (is_restarted) r.lift_model.power_cycle();
        r.wire.set_connected(1, true);
        r.loop(3000);
        CHECK_FALSE(r.p.all.is_absent(2));
        CHECK((r.p.lift.state() == yako::drive_state::needs_init) == is_restarted);
        CHECK((r.p.lift.current_word_order() == word_order::unknown) == is_restarted);
        CHECK(r.command(r.p.lift, init{}));
    }
}

TEST_CASE("G21, G22: a lost port invalidates all cached settings and the word orders of the bus") {
    rig r;
    r.drive_wheels();
    r.loop(200);
    REQUIRE(r.p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(200)));
    r.wire.unplug();
    r.loop(30);
    r.wire.plug();
    CHECK(r.p.wheels.state() == zlac8015d::drive_state::needs_init);
    CHECK(r.p.lift.state() == yako::drive_state::needs_init);
    const std::uint32_t reads = r.p.all.count(2);
    r.loop(6000);
    CHECK(r.wheels_model.stands_still());
    CHECK(r.p.all.count(2) == reads);
    CHECK(r.p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(500)).error() ==
          errc::needs_init);
    CHECK(r.p.all.latest<zlac8015d::bus_voltage>(tests::wheels_node, milliseconds(500)).error() ==
          errc::needs_init);
}

TEST_CASE("G36: values of before a lost port are not given once the drive is known again") {
    rig r;
    r.place_lift();
    r.wire.unplug();
    r.loop(30);
    r.lift_model.power_cycle();
    r.wire.plug();
    r.loop(30);
    REQUIRE(r.p.lift.begin(init{}) == errc::ok);
    unsigned given = 0;
    for (int i = 0; i < 3'000; ++i) {
        r.turn();
        const auto now = r.p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(60'000));
        if (now) CHECK(*now == 0 * pulse);
        given += now ? 1u : 0u;
    }
    CHECK(given > 100);
}

TEST_CASE("G22: values that were read in a word order which the drive no longer has are not given once that "
          "is known") {
    rig r;
    r.place_lift();
    const std::uint8_t low_first[]{0, 1};
    REQUIRE(r.lift_model.write(yako::pair_word_order.address, words_view{low_first}) ==
            0);  // by another client
    r.loop(250); // two refreshes
    REQUIRE(r.p.lift.begin(init{}) == errc::ok);
    unsigned given = 0;
    for (int i = 0; i < 3'000; ++i) {
        r.turn();
        if (r.p.lift.current_word_order() != word_order::low_first) continue;
        const auto now = r.p.all.latest<yako::actual_position>(tests::lift_node, milliseconds(60'000));
        if (now) CHECK(*now == 300 * pulse);
        given += now ? 1u : 0u;
    }
    CHECK(given > 100);
}

TEST_CASE("G21: a drive that was absent while a command was in progress needs initialisation if it has "
          "restarted meanwhile, and only then") {
    const yako::motion_profile by{20 * r_per_min, 50 * millisecond, 50 * millisecond, 120 * r_per_min};
    for (unsigned ms = 0; ms < 300; ms += 10) {
        const bool is_restarted = ms % 20 == 0;
        CAPTURE(ms);
        rig r;
        r.drive_wheels();
        r.wire.set_connected(1, false);
        r.loop(ms);
        (void)r.p.lift.begin(move_by{1000 * pulse, by});
        for (tests::loop_bound left{"an event"}; !r.p.all.is_absent(2); left.use()) r.turn();
        if (is_restarted) r.lift_model.power_cycle();
        r.wire.set_connected(1, true);
        SUBCASE("a stop replaces the command") {
            REQUIRE(r.p.lift.begin(quick_stop{}) == errc::ok);
            for (tests::loop_bound left{"the end of a command"}; !r.p.lift.is_idle(); left.use()) r.turn();
            REQUIRE(r.p.lift.last());
        }
        SUBCASE("the command runs to its end") {
            for (tests::loop_bound left{"the end of a command"}; !r.p.lift.is_idle(); left.use()) r.turn();
        }
        const bool was_known = r.p.lift.state() != yako::drive_state::needs_init;
        const std::uint32_t starts = r.lift_model.starts(); // of the command that ran to its end
        const command_status next = r.command(r.p.lift, move_by{1000 * pulse, by});
        if (is_restarted) CHECK(next.error() == errc::needs_init);
        if (is_restarted) CHECK(starts == 0);
        if (!is_restarted && starts == 0) CHECK(static_cast<bool>(next) == was_known);
        CHECK(r.lift_model.starts() == starts + (next ? 1 : 0));
    }
}

} // namespace bus_return_tests
