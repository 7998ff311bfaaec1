// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a bus does with the drives that it is given: it polls those of its plan and sets their times, and refuses the
// others. And a node with a keep-alive that has never responded.
#include <doctest/doctest.h>

#include <cstdint>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace bus_drives_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using line_type = scheduled_line<sim::virtual_line>;
using wheels_type = zlac8015d::drive<line_type>;
using tests::wheels_and_lift, tests::wheels_node;

template <class Bus> void loop(Bus& all, sim::virtual_line& wire, std::uint32_t ms) {
    const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000;
    while (wire.time_us() < end) {
        const duration idle = all.step();
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
}

constexpr poll_plan of_wheels{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)})};

constexpr poll_plan of_both{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}),
    controlled(tests::lift_node, {.feedback = milliseconds(30), .command_timeout = no_command_timeout})};

} // namespace

TEST_CASE("G20, G36: a bus polls its drives and gives them its command timeout") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, wheels_node, by_plan}; // neither polled nor supervised by itself
    auto all = make_bus<of_wheels>(on, wheels);
    REQUIRE(all.run(wheels, init{}));
    REQUIRE(all.run(wheels, enable{}));
    REQUIRE(all.run(wheels, velocity{50 * r_per_min, 50 * r_per_min}));
    loop(all, m.wire, 250);
    CHECK(wheels.feedback(milliseconds(25)));
    CHECK_FALSE(m.wheels_model.stands_still());
    loop(all, m.wire, 1500);
    CHECK(m.wheels_model.stands_still());
}

TEST_CASE("G20: a blocking command of a bus is a sign of life for its own drive, and for no other") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, wheels_node, by_plan};
    yako::closed_loop::drive lift{on, tests::lift_node};
    auto all = make_bus<of_both>(on, wheels, lift);
    REQUIRE(all.run(wheels, init{}));
    REQUIRE(all.run(lift, init{}));
    REQUIRE(all.run(lift, enable{}));
    REQUIRE(all.run(wheels, enable{}));
    REQUIRE(all.run(wheels, velocity{50 * r_per_min, 50 * r_per_min}));
    SUBCASE("a wait for the wheels, which turn on for all of it") {
        loop(all, m.wire, 100); // they have begun to turn
        CHECK(all.run(wheels, wait_standstill{}).error() == errc::not_reached);
        CHECK_FALSE(m.wheels_model.stands_still());
        loop(all, m.wire, 1500);
    }
    SUBCASE("a long move of the lift") {
        const std::uint64_t begun = m.wire.time_us();
        const auto there = all.run(lift, move_by{20'000 * pulse}, wait_reached{});
        CHECK(there.how == arrival_state::reached);
        REQUIRE(m.wire.time_us() - begun > 1'500'000);
    }
    CHECK(m.wheels_model.stands_still());
}

TEST_CASE("a bus refuses a drive on another line, and polls it no more") {
    wheels_and_lift here;
    wheels_and_lift there;
    line_type on{here.wire, modbus::timing_at(115200)};
    line_type elsewhere{there.wire, modbus::timing_at(115200)};
    wheels_type wheels{
        elsewhere, wheels_node, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}};
    REQUIRE(wheels.run(init{}));
    auto all = make_bus<of_wheels>(on, wheels);
    const std::uint32_t sent = there.wire.requests();
    for (int i = 0; i < 2000; ++i) {
        const duration idle = all.step();
        for (sim::virtual_line* wire : {&here.wire, &there.wire})
            wire->pass(idle.us == 0 ? microseconds(1) : idle);
    }
    CHECK(there.wire.requests() == sent);
    CHECK(here.wire.requests() == 0);
    CHECK(wheels.begin(enable{}) == errc::bad_argument);
    CHECK(wheels.begin(disable{}) == errc::ok); // a stop
}

TEST_CASE("a bus runs no command of a drive that is not its own") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, wheels_node, by_plan}, other{on, wheels_node, unsupervised};
    auto all = make_bus<of_wheels>(on, wheels);
    const std::uint32_t before = m.wire.requests();
    CHECK(all.run(other, init{}).error() == errc::bad_argument);
    CHECK(m.wire.requests() == before);
    CHECK(other.state() == drive_state::needs_init);
    CHECK(all.run(wheels, init{}));
}

TEST_CASE("a drive by its plan refuses all but stops until a bus has adopted it") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, wheels_node, by_plan};
    CHECK(wheels.begin(init{}) == errc::bad_argument);
    CHECK(wheels.run(init{}) == errc::bad_argument);
    for (int i = 0; i < 100; ++i) m.wire.wait(wheels.step());
    CHECK(m.wire.requests() == 0);
    CHECK(wheels.run(disable{}).outcome() != outcome::not_sent); // a stop
    REQUIRE(m.wire.requests() != 0);
    auto all = make_bus<of_wheels>(on, wheels);
    CHECK(all.run(wheels, init{}));
    const std::uint32_t before = m.wire.requests();
    loop(all, m.wire, 300);
    CHECK(m.wire.requests() > before + 2); // its feedback, as the plan says
}

TEST_CASE("a bus refuses a drive that has another address than the one in its place of the plan") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, responds_within(node<zlac8015d::device>{9}, milliseconds(30)), by_plan};
    auto all = make_bus<of_wheels>(on, wheels);
    const std::uint32_t before = m.wire.requests();
    CHECK(wheels.begin(init{}) == errc::bad_argument);
    loop(all, m.wire, 300);
    CHECK(m.wire.requests() == before);
    CHECK(wheels.begin(disable{}) == errc::ok); // a stop
}

namespace {
constexpr poll_plan of_another_lift{
    modbus::timing_at(115200),
    controlled(responds_within(node<yako::closed_loop::device>{3}, milliseconds(30)),
               {.feedback = milliseconds(30), .command_timeout = no_command_timeout})};

constexpr poll_plan of_both_rarely{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(2000), .command_timeout = no_command_timeout}),
    controlled(tests::lift_node, {.feedback = milliseconds(2000), .command_timeout = no_command_timeout})};

/// A read that is not the bus's, as urgent as those of its plan.
struct own_read {
    response_limits limits{.response = milliseconds(50)};
    modbus::frame<8> request = modbus::read_frame(1, zlac8015d::bus_voltage.address, 1);
    std::uint8_t response[7]{};
    modbus::exchange x;

    explicit own_read(const line_type& on) : x{request, response, on.timing(), limits, priority::planned} {}
    own_read(const own_read&) = delete;
};
} // namespace

TEST_CASE("a drive that a bus refuses for its address reads its stop back beside the bus") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    yako::closed_loop::drive lift{on, tests::lift_node};
    REQUIRE(lift.run(init{}));
    REQUIRE(lift.run(enable{}));
    auto all = make_bus<of_another_lift>(on, lift);
    loop(all, m.wire, 300);
    REQUIRE(m.lift_model.enabled());
    CHECK(all.run(lift, disable{}));
    CHECK_FALSE(m.lift_model.enabled());
}

TEST_CASE(
    "G28: the drive that has waited longest goes first, also where the tickets begin again between both") {
    for (const bool is_lift_first : {false, true}) {
        CAPTURE(is_lift_first);
        wheels_and_lift m;
        line_type on{m.wire, modbus::timing_at(115200)};
        wheels_type wheels{on, wheels_node, by_plan};
        yako::closed_loop::drive lift{on, tests::lift_node};
        auto all = make_bus<of_both_rarely>(on, wheels, lift);
        REQUIRE(all.run(wheels, init{}));
        REQUIRE(all.run(lift, init{}));
        loop(all, m.wire, 100);
        for (std::uint16_t ticket = 0; ticket != 0xFFFC;) {
            own_read given_up{on};
            (void)on.step(given_up.x, bus_gaps{});
            on.abandon(given_up.x);
            ticket = given_up.x.ticket();
        }
        simulated::request_log log;
        m.wire.set_hook(&simulated::request_log::note, &log);
        m.wheels_station.set_response_delay(milliseconds(15));
        own_read before{on};
        for (tests::loop_bound left{"a request"}; log.frames.empty(); left.use())
            m.wire.wait(longer_of(on.step(before.x, bus_gaps{}), microseconds(1)));
        const auto ask = [&](bool is_lift) {
            REQUIRE((is_lift ? lift.begin(read_feedback{}) : wheels.begin(read_feedback{})) == errc::ok);
            (void)all.step();
            return is_lift ? lift.machine().ticket() : wheels.machine().ticket();
        };
        REQUIRE(ask(is_lift_first) == 0xFFFE);
        REQUIRE(ask(!is_lift_first) == 1);
        for (tests::loop_bound left{"two requests"}; log.frames.size() < 3; left.use()) {
            const duration idle = shorter_of(on.step(before.x, bus_gaps{}), all.step());
            m.wire.wait(longer_of(idle, microseconds(1)));
        }
        CHECK(before.x.status());
        CHECK(log.frames[1][0] == (is_lift_first ? 2 : 1));
        CHECK(log.frames[2][0] == (is_lift_first ? 1 : 2));
    }
}

TEST_CASE("G28: a bus says of each node whether it is absent, also of a drive that it controls") {
    wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    REQUIRE(p.command(p.lift, init{}));
    REQUIRE(p.command(p.wheels, init{}));
    p.run(500);
    CHECK_FALSE(p.all.is_absent(1));
    CHECK_FALSE(p.all.is_absent(2));
    m.wire.set_connected(1, false); // the lift
    p.run(2000);
    CHECK_FALSE(p.all.is_absent(1));
    CHECK(p.all.is_absent(2));
    CHECK(p.lift.is_absent());
    m.wire.set_connected(1, true);
    p.run(2000);
    CHECK_FALSE(p.all.is_absent(2));
}

TEST_CASE("a move that a bus cannot begin has no arrival") {
    wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    const auto end = wait_reached{milliseconds(1000)};
    const zlac8015d::arrival came = p.all.run(p.wheels, move_by{100 * pulse, 100 * pulse}, end);
    CHECK(came.how == arrival_state::none);
    CHECK(p.wheels.last().error() == errc::needs_init);
    CHECK(m.wire.requests() == 0);
}

namespace {
constexpr poll_plan with_a_keep_alive{
    modbus::timing_at(115200),
    cyclic<zlac8015d::status_word>(wheels_node, milliseconds(50)).keeps_alive(milliseconds(2000))};
} // namespace

TEST_CASE("after a blocking call of a bus no request of its drives is left without the end of its exchange") {
    wheels_and_lift m;
    tests::wheels_and_lift_program p{m.wire};
    REQUIRE(p.command(p.wheels, init{}));
    REQUIRE(p.command(p.lift, init{}));
    for (std::uint32_t i = 0; i < 300; ++i) {
        if (i % 2 == 0) REQUIRE(p.all.run(p.lift, read_feedback{}));
        if (i % 2 != 0) p.all.run_for(microseconds(2000 + 37 * i));
        CHECK(m.wire.requests() == m.wire.responses());
    }
}

namespace {
constexpr poll_plan every_50_ms{modbus::timing_at(115200),
                                cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(50))};
} // namespace

TEST_CASE("a bus reads when a read is due, if it is stepped when it wants to be, and delivers what the node "
          "holds") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    auto all = make_bus<every_50_ms>(on);
    loop(all, m.wire, 100);
    std::uint64_t last = 0;
    for (int i = 0; i < 30; ++i) {
        const std::uint32_t sent = m.wire.requests();
        while (m.wire.requests() == sent) {
            const duration idle = all.step();
            m.wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        if (last != 0) CHECK(m.wire.time_us() - last <= 50'300);
        if (last != 0) CHECK(m.wire.time_us() - last >= 49'700);
        last = m.wire.time_us();
    }
    loop(all, m.wire, 20);
    auto voltage = all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(100));
    REQUIRE(voltage);
    CHECK(voltage->count() == m.wheels_model.peek(zlac8015d::bus_voltage.address));
    CHECK(voltage->count() != 0);
}

namespace {
constexpr poll_plan read_only{modbus::timing_at(115200), back_off{.retry_every = milliseconds(10'000)},
                              cyclic<zlac8015d::status_word>(wheels_node, milliseconds(200))};
} // namespace

TEST_CASE("G28: a node that has never responded is absent after three reads") {
    wheels_and_lift m;
    m.wire.set_connected(0, false);
    line_type on{m.wire, modbus::timing_at(115200)};
    auto all = make_bus<read_only>(on);
    loop(all, m.wire, 5000);
    CHECK(m.wire.requests() == 3);
}

TEST_CASE("G28: a node with a keep-alive that has never responded is read less often") {
    wheels_and_lift m;
    m.wire.set_connected(0, false);
    line_type on{m.wire, modbus::timing_at(115200)};
    auto all = make_bus<with_a_keep_alive>(on);
    loop(all, m.wire, 1000); // three failures
    const std::uint32_t before = m.wire.requests();
    loop(all, m.wire, 10'000);
    CHECK(m.wire.requests() - before <= 11); // once a second
    CHECK(m.wire.requests() - before >= 9);
}

TEST_CASE("G28: a drive that waits for the line keeps its place when another of its frames becomes due") {
    tests::wheels_and_lift r;
    tests::wheels_and_lift_program p{r.wire};
    REQUIRE(p.command(p.wheels, init{}));
    REQUIRE(p.command(p.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
    REQUIRE(p.command(p.lift, init{}));
    r.wheels_station.set_response_delay(milliseconds(15));
    r.lift_station.set_response_delay(milliseconds(15));
    simulated::request_log log;
    r.wire.set_hook(&simulated::request_log::note, &log);
    const auto is_read_of = [&](std::uint16_t address) {
        return log.frames.back()[1] == 3 && load_word(log.frames.back(), 2) == address;
    };
    unsigned seen = 0;
    for (unsigned turns = 0; turns < 4'000'000 && seen < 20; ++turns) {
        p.turn();
        const std::uint16_t own = p.wheels.machine().ticket();
        const std::uint16_t other = p.lift.machine().ticket();
        const bool is_older = own != 0 && other != 0 && static_cast<std::int16_t>(other - own) > 0;
        if (!is_older || log.frames.empty() || !is_read_of(0x20A1) || !log.open.empty()) continue;
        // The read of the wheels' voltage gets no response: in place of the feedback their witness is due.
        r.wire.set_connected(0, false);
        const std::size_t before = log.frames.size();
        while (log.frames.size() == before) p.turn();
        r.wire.set_connected(0, true);
        // A cyclic read may have waited longer.
        while (is_read_of(0x004B) || is_read_of(0x000A) || is_read_of(0x20A1)) {
            const std::size_t reads = log.frames.size();
            while (log.frames.size() == reads) p.turn();
        }
        CAPTURE(seen);
        CHECK(is_read_of(0x200D)); // and not the lift's feedback
        ++seen;
        p.run(500);
        REQUIRE(p.wheels.state() == drive_state::enabled);
    }
    CHECK(seen >= 5);
}

} // namespace bus_drives_tests
