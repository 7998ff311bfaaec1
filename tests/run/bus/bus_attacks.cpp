// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Attacks on a bus and its drives: a drive that is not the plan's, a pause of the program, a stop that an init
// replaces, stops that are taken back, and times that wrap. Judged by the frames on the wire and by the simulated
// drives.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/scripted_port.hpp>

namespace bus_attacks_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using line_type = scheduled_line<sim::virtual_line>;
using wheels_type = zlac8015d::drive<line_type>;
using lift_type = yako::closed_loop::drive<line_type>;
using tests::lift_node, tests::wheels_node, tests::wheels_and_lift, tests::wheels_and_lift_program;

/// The requests on a wire, with their ends.
struct requests {
    std::vector<std::vector<std::uint8_t>> all{};
    std::vector<std::uint64_t> ends{};
    std::vector<std::uint8_t> open{};

    explicit requests(sim::virtual_line& wire) { wire.set_hook(&requests::note, this); }
    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<requests*>(self);
        r.open.push_back(b.value);
        if (r.open.size() != modbus::request_length(r.open)) return;
        r.all.push_back(r.open);
        r.ends.push_back(b.at_us);
        r.open.clear();
    }
};

template <class Bus> void loop(Bus& all, sim::virtual_line& wire, std::uint32_t ms) {
    const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000;
    while (wire.time_us() < end) {
        const duration idle = all.step();
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
}

constexpr supervision often{.feedback = milliseconds(30), .command_timeout = no_command_timeout};
constexpr poll_plan of_another_lift{
    modbus::timing_at(115200),
    controlled(responds_within(node<yako::closed_loop::device>{3}, milliseconds(30)), often)};

} // namespace

TEST_CASE(
    "a bus polls no drive at another address than its plan's, and that drive takes no command but stops") {
    wheels_and_lift m;
    requests seen{m.wire};
    line_type on{m.wire, modbus::timing_at(115200)};
    lift_type lift{on, lift_node};
    REQUIRE(lift.run(init{}));
    REQUIRE(lift.begin(enable{}) == errc::ok);
    auto all = make_bus<of_another_lift>(on, lift);
    loop(all, m.wire, 1000);
    CHECK(lift.begin(move_by{100 * pulse}) == errc::bad_argument);
    seen.all.clear();
    m.wire.set_connected(1, false);
    loop(all, m.wire, 2000);
    CHECK(seen.all.empty());
    CHECK_FALSE(lift.feedback(milliseconds(100)));
    m.wire.set_connected(1, true);
    CHECK(all.run(lift, disable{}));
    for (const auto& f : seen.all) CHECK(f[0] == 2);
}

TEST_CASE("a bus runs no command of a drive that is not on it") {
    wheels_and_lift m;
    wheels_and_lift_program p{m.wire};
    lift_type other{p.on, responds_within(node<yako::closed_loop::device>{3}, milliseconds(30))};
    CHECK(p.all.run(other, init{}).error() == errc::bad_argument);
    CHECK(m.wire.requests() == 0);
}

TEST_CASE("G2, G22: feedback is not decoded in another word order than it was read in") {
    wheels_and_lift m;
    wheels_and_lift_program p{m.wire};
    REQUIRE(p.command(p.lift, init{}));
    REQUIRE(p.command(p.lift, enable{}));
    REQUIRE(p.command(p.lift, declare_position{0 * pulse}));
    REQUIRE(p.command(p.lift, move_by{300 * pulse}));
    p.run(1500);
    REQUIRE(p.lift.feedback(milliseconds(1000))->position == 300 * pulse);
    REQUIRE(p.lift.begin(yako::set_word_order{yako::word_order_setting::low_first}) == errc::ok);
    unsigned right = 0;
    for (int i = 0; i < 600; ++i) {
        p.turn();
        const auto now = p.lift.feedback(milliseconds(1000));
        if (now) REQUIRE(now->position == 300 * pulse);
        right += now ? 1u : 0u;
    }
    CHECK(right > 100);
}

TEST_CASE("G25: the stop of a command timeout has left within the plan's bound also if an init replaces it") {
    for (std::uint32_t k = 0; k < 60; ++k) {
        CAPTURE(k);
        wheels_and_lift m;
        requests seen{m.wire};
        wheels_and_lift_program p{m.wire};
        REQUIRE(p.command(p.wheels, init{}));
        REQUIRE(p.command(p.lift, init{}));
        REQUIRE(p.command(p.lift, enable{}));
        p.lift.set_command_timeout(milliseconds(300));
        REQUIRE(p.command(p.lift, velocity{30 * r_per_min}));
        m.wire.set_connected(0, false); // the wheels do not respond
        m.wire.pass(microseconds(k * 1277u));
        while (p.lift.is_idle()) p.turn();
        const std::uint64_t ordered = m.wire.time_us();
        const std::size_t before = seen.all.size();
        CHECK(p.lift.begin(init{}) == errc::ok);
        std::size_t stop = before;
        const auto is_stop = [&](std::size_t i) {
            return seen.all[i][0] == 2 && seen.all[i][1] == 6 && seen.all[i][3] == 0x27;
        };
        while (stop >= seen.all.size() || !is_stop(stop)) {
            if (stop < seen.all.size())
                ++stop;
            else
                p.turn();
        }
        CHECK(seen.ends[stop] - ordered <= tests::fast_plan.worst_case_stop_latency().us);
    }
}

namespace {
constexpr poll_plan seldom{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(1000), .command_timeout = no_command_timeout})
        .keeps_alive(milliseconds(400))};
} // namespace

TEST_CASE("G19: a wait for the end of a move keeps the drive's watchdog from expiring, as its plan says") {
    static_assert(seldom.longest_gap(seldom.controlled[0]) < milliseconds(375));
    static_assert(seldom.load_per_mille() > 70); // by the reads that keep it alive
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    wheels_type wheels{on, wheels_node, by_plan};
    auto all = make_bus<seldom>(on, wheels);
    using namespace zlac8015d;
    REQUIRE(all.run(wheels, init{}));
    REQUIRE(all.run(wheels, watchdog{400 * millisecond}));
    REQUIRE(all.run(wheels, enable_in{operating_mode::relative_position}));
    const auto there = all.run(wheels, move_by{40960 * pulse, 40960 * pulse}, wait_reached{});
    CHECK(there.how == arrival_state::reached);
    CHECK_FALSE(m.wheels_model.in_watchdog_stop());
}

TEST_CASE("G16: a response that arrived while the program paused is taken, with and without a bus") {
    for (const bool has_bus : {false, true}) {
        CAPTURE(has_bus);
        wheels_and_lift m;
        requests seen{m.wire};
        wheels_and_lift_program p{m.wire};
        REQUIRE(p.command(p.lift, init{}));
        const epoch before = p.on.epoch(2);
        REQUIRE(p.lift.begin(enable{}) == errc::ok);
        const auto turn = [&] {
            if (has_bus) return p.turn();
            const duration idle = p.lift.step();
            m.wire.wait(idle.us == 0 ? microseconds(1) : idle);
        };
        while (seen.all.empty() || seen.all.back()[1] != 6 || seen.all.back()[3] != 0x2D) turn();
        m.wire.pass(milliseconds(1200));
        for (tests::loop_bound left{"the end of a command"}; !p.lift.is_idle(); left.use()) turn();
        CHECK(p.lift.last());
        CHECK(p.lift.state() == yako::drive_state::enabled);
        CHECK(p.on.epoch(2) == before);
    }
}

namespace {
constexpr poll_plan with_equal_times{
    modbus::timing_at(115200),
    controlled(lift_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(100)})};
} // namespace

TEST_CASE(
    "G26: the stops of a bus are repeated also if its command timeout, of the same time, is taken away") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    lift_type lift{on, lift_node};
    auto all = make_bus<with_equal_times>(on, lift);
    lift.set_command_timeout(no_command_timeout);
    REQUIRE(all.run(lift, init{}));
    REQUIRE(all.run(lift, enable{}));
    REQUIRE(all.run(lift, velocity{30 * r_per_min}));
    all.run_for(milliseconds(300));
    m.wire.set_connected(1, false);
    REQUIRE_FALSE(all.run(lift, quick_stop{}));
    m.wire.set_connected(1, true);
    all.run_for(milliseconds(5000));
    CHECK_FALSE(m.lift_model.view().is_moving);
}

TEST_CASE("G26: a weaker stop that fails too leaves the stronger one to be repeated") {
    wheels_and_lift m;
    wheels_and_lift_program p{m.wire};
    REQUIRE(p.command(p.lift, init{}));
    REQUIRE(p.command(p.lift, enable{}));
    m.wire.set_connected(1, false);
    REQUIRE_FALSE(p.command(p.lift, disable{}));
    command_status refused = errc::busy;
    while (refused == errc::busy) {
        p.turn();
        refused = p.lift.begin(halt{});
    }
    for (tests::loop_bound left{"the end of a command"}; !p.lift.is_idle(); left.use()) p.turn();
    m.wire.set_connected(1, true);
    p.run(3000);
    CHECK_FALSE(m.lift_model.enabled());
}

TEST_CASE("G34: a move that was stopped short stays so for hours") {
    wheels_and_lift m;
    line_type on{m.wire, modbus::timing_at(115200)};
    lift_type lift{on, lift_node, unsupervised};
    REQUIRE(lift.run(init{}));
    REQUIRE(lift.run(enable{}));
    REQUIRE(lift.begin(move_by{3000 * pulse}) == errc::ok);
    for (int i = 0; i < 400; ++i) {
        (void)lift.step();
        m.wire.pass(milliseconds(1));
    }
    REQUIRE(lift.run(quick_stop{}));
    REQUIRE(lift.read());
    m.wire.pass(milliseconds(1000));
    REQUIRE(lift.read());
    REQUIRE(lift.arrival().how == arrival_state::stopped_short);
    for (int minutes = 0; minutes < 150; ++minutes) {
        CAPTURE(minutes);
        for (int i = 0; i < 6; ++i) {
            m.wire.pass(milliseconds(10'000));
            (void)lift.step();
        }
        REQUIRE(lift.read());
        REQUIRE(lift.arrival().how == arrival_state::stopped_short);
    }
}

TEST_CASE("a drive that was not asked yet is not absent") {
    wheels_and_lift m;
    wheels_and_lift_program p{m.wire};
    CHECK_FALSE(p.all.is_absent(1));
    CHECK_FALSE(p.wheels.is_absent());
    p.run(2000);
    CHECK_FALSE(p.wheels.is_absent());
    m.wire.set_connected(0, false);
    CHECK_FALSE(p.command(p.wheels, init{}));
    CHECK(p.wheels.is_absent());
    m.wire.set_connected(0, true);
    CHECK(p.command(p.wheels, init{}));
    CHECK_FALSE(p.wheels.is_absent());
}

namespace {
template <class Device> constexpr node<Device> gapped(std::uint8_t address) {
    node<Device> n{address};
    n.limits.response = milliseconds(30);
    n.gaps = {.gap = milliseconds(15), .quarantine = milliseconds(100)};
    return n;
}
constexpr poll_plan with_long_gaps{
    modbus::timing_at(115200, modbus::timing_mode::strict),
    controlled(gapped<yako::closed_loop::device>(1), unsupervised),
    cyclic<yako::status_word>(gapped<yako::closed_loop::device>(2), milliseconds(100))};
} // namespace

TEST_CASE(
    "G25: the bound of a stop counts a late response that begins just before the node's own gap is over") {
    for (std::uint64_t late = 30'000; late < 46'000; late += 500) {
        CAPTURE(late);
        tests::scripted_port port;
        scheduled_line<tests::scripted_port> on{port, with_long_gaps.timing()};
        yako::closed_loop::drive<scheduled_line<tests::scripted_port>> lift{
            on, gapped<yako::closed_loop::device>(1)};
        auto all = make_bus<with_long_gaps>(on, lift);
        port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
            if (f.data[0] == 2) p.say(late, tests::read_response(2, {0}));
        };
        while (port.frames.empty()) (void)all.step();
        const std::uint64_t ordered = port.time;
        REQUIRE(lift.begin(quick_stop{}) == errc::ok);
        while (port.frames.size() < 2 || !port.frames.back().complete) (void)all.step();
        CHECK(port.frames.back().end - ordered <= with_long_gaps.worst_case_stop_latency().us);
    }
}

} // namespace bus_attacks_tests
