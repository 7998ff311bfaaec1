// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How long responses of other drives, slow or late ones, may delay the next request or the stop of a drive.
// And plans whose times exceed the longest duration.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include <servobus/bus/bus.hpp>
#include <servobus/client/client.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace bus_keep_alive_tests {

using namespace servobus;

namespace {

struct counting_store {
    std::uint32_t reads = 0;

    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        ++reads;
        for (std::uint16_t& word : to) word = address++;
        return 0;
    }
    static std::uint8_t write(std::uint16_t, words_view) { return 0; }
};
using station = sim::station<counting_store>;

consteval node<zlac8015d::device> granted(std::uint8_t node_address, duration response, duration quarantine) {
    node<zlac8015d::device> n{node_address};
    n.limits.response = response;
    n.gaps.quarantine = quarantine;
    return n;
}
consteval auto status_of(const node<zlac8015d::device>& at, duration period) {
    return cyclic<zlac8015d::status_word>(at, period);
}

// A bus of `Plan`, whose first read is of node 1. The test attaches the other nodes.
template <const auto& Plan> struct rig {
    counting_store kept;
    counting_store others;
    station first{kept, 1, 115200};
    sim::virtual_line wire{115200};
    scheduled_line<sim::virtual_line> on{wire, Plan.timing()};
    bus<Plan, scheduled_line<sim::virtual_line>> all{on};

    rig() { wire.attach(first); }
    rig(const rig&) = delete;

    // The longest time between two requests to node 1.
    std::uint64_t longest_gap_within(std::uint64_t us) {
        std::uint64_t longest = 0;
        std::uint64_t last = 0;
        std::uint32_t seen = 0;
        while (wire.time_us() < us) {
            const duration idle = all.step();
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
            if (kept.reads == seen) continue;
            seen = kept.reads;
            if (last != 0) longest = std::max(longest, wire.time_us() - last);
            last = wire.time_us();
        }
        return longest;
    }
};

constexpr poll_plan beside_a_slow_one{
    modbus::timing_at(115200), back_off{.failures = 255},
    status_of(granted(1, milliseconds(20), milliseconds(25)), milliseconds(100))
        .keeps_alive(milliseconds(540)),
    status_of(granted(2, milliseconds(300), milliseconds(25)), milliseconds(20))};

constexpr auto kept_node = granted(1, milliseconds(20), milliseconds(60));
constexpr poll_plan beside_late_ones{
    modbus::timing_at(115200),
    back_off{.failures = 255},
    status_of(kept_node, milliseconds(100)).keeps_alive(milliseconds(700)),
    status_of(granted(2, milliseconds(20), milliseconds(60)), milliseconds(400)),
    status_of(granted(3, milliseconds(20), milliseconds(60)), milliseconds(400)),
    status_of(granted(4, milliseconds(20), milliseconds(60)), milliseconds(400))};

} // namespace

TEST_CASE("G19: a read that takes longer than its period goes at most once ahead of a read that is due") {
    for (std::uint32_t ms = 100; ms < 300; ms += 7) {
        CAPTURE(ms);
        rig<beside_a_slow_one> r;
        station slow{r.others, 2, 115200, milliseconds(ms)};
        r.wire.attach(slow);
        CHECK(r.longest_gap_within(20'000'000) <=
              beside_a_slow_one.longest_gap(beside_a_slow_one.polls[0]).us);
    }
}

TEST_CASE(
    "G19: the times of a plan include responses that arrive as the quarantine ends, and so cost it twice") {
    rig<beside_late_ones> r;
    const duration late = milliseconds(78);
    station second{r.others, 2, 115200, late};
    station third{r.others, 3, 115200, late};
    station fourth{r.others, 4, 115200, late};
    for (station* other : {&second, &third, &fourth}) r.wire.attach(*other);
    const std::uint64_t longest = r.longest_gap_within(60'000'000);
    CHECK(longest <= beside_late_ones.longest_gap(beside_late_ones.polls[0]).us);
    CHECK(longest > 3 * (20'000 + 2 * 58'000));
}

namespace {
constexpr poll_plan of_one_drive{
    modbus::timing_at(115200), controlled(kept_node, unsupervised), status_of(kept_node, milliseconds(100)),
    cyclic<zlac8015d::hall_state>(kept_node, milliseconds(200)),
    status_of(granted(2, milliseconds(20), milliseconds(60)), milliseconds(400))};
} // namespace

TEST_CASE("G19: every other request to a drive keeps it alive too") {
    const poll& own = of_one_drive.polls[0];
    const duration others = of_one_drive.longest(of_one_drive.polls[2]);
    CHECK(of_one_drive.longest_gap(own) == own.period + of_one_drive.longest(own) + others);
}

TEST_CASE("G19: the times of a plan are the same at run time and at compile time") {
    constexpr duration gap = of_one_drive.longest_gap(of_one_drive.polls[0]);
    constexpr duration stop = of_one_drive.longest_stop();
    constexpr duration pause = of_one_drive.longest_stop_pause();
    constexpr duration found = of_one_drive.rediscovery_bound();
    constexpr duration latency = of_one_drive.worst_case_stop_latency();
    auto plan = of_one_drive; // not const: the compiler cannot evaluate the calls
    CHECK(plan.longest_gap(plan.polls[0]) == gap);
    CHECK(plan.longest_stop() == stop);
    CHECK(plan.longest_stop_pause() == pause);
    CHECK(plan.rediscovery_bound() == found);
    CHECK(plan.worst_case_stop_latency() == latency);
    CHECK(latency < found);
}

namespace {
constexpr node<c630s::device> servo_node = [] {
    node<c630s::device> n{1};
    n.limits.response = milliseconds(400);
    return n;
}();
constexpr auto wheels_node = granted(2, milliseconds(30), milliseconds(40));
constexpr poll_plan beside_a_servo{modbus::timing_at(57600), controlled(wheels_node, unsupervised),
                                   controlled(servo_node, {.command_timeout = no_command_timeout}),
                                   status_of(wheels_node, milliseconds(50)),
                                   cyclic<c630s::bus_voltage>(servo_node, milliseconds(2000))};
} // namespace

TEST_CASE(
    "G25: a bus caps the response time of a drive at that of its plan, whatever delay the drive is set to") {
    for (std::uint32_t offset = 0; offset < 20; ++offset) {
        CAPTURE(offset);
        sim::c630s model;
        sim::station<sim::c630s> drive{model};
        sim::virtual_line wire{57600};
        wire.attach(drive);
        scheduled_line on{wire, beside_a_servo.timing()};
        zlac8015d::drive<decltype(on)> wheels{on, wheels_node, by_plan}; // not on the line
        c630s::drive<decltype(on)> servo{on, servo_node};
        auto all = make_bus<beside_a_servo>(on, wheels, servo);
        REQUIRE(client{on, servo_node}.store<c630s::response_delay>(350));
        all.run_for(milliseconds(3000));
        REQUIRE(all.run(servo, init{}));
        CHECK(servo.machine().terms().limits().response.us <= beside_a_servo.longest_response().us);
        wire.set_connected(0, false);
        REQUIRE(servo.begin(init{}) == errc::ok);
        all.run_for(milliseconds(30 + 40 * offset));
        const std::uint64_t ordered = wire.time_us();
        REQUIRE(wheels.begin(quick_stop{}) == errc::ok);
        while (wheels.machine().wants_stop()) {
            const duration idle = all.step();
            wire.wait(idle.us == 0 ? microseconds(1) : idle);
        }
        CHECK(wire.time_us() - ordered <= beside_a_servo.worst_case_stop_latency().us);
    }
}

namespace {
constexpr auto patient = granted(1, milliseconds(1'000'000), milliseconds(25));
template <std::size_t... I> consteval auto many(duration period, std::index_sequence<I...>) {
    return poll_plan{modbus::timing_at(9600),
                     status_of(granted(std::uint8_t(1 + I), milliseconds(20), milliseconds(25)), period)...};
}
constexpr auto forty = many(milliseconds(3500), std::make_index_sequence<40>{});
} // namespace

TEST_CASE("a time of a plan that exceeds the longest duration is the longest duration") {
    static constexpr poll_plan slow{modbus::timing_at(9600), status_of(patient, milliseconds(1000))};
    CHECK(slow.rediscovery_bound(1) > milliseconds(1'000'000));
    CHECK(slow.rediscovery_bound(1) < milliseconds(1'100'000));
    CHECK(slow.rediscovery_bound(5).us == 0xFFFF'FFFF);
    CHECK(slow.rediscovery_bound(0xFFFF'FFFF).us == 0xFFFF'FFFF);
    CHECK(slow.worst_case_stop_latency(5) < milliseconds(1'100'000)); // no facade
    CHECK(slow.absent_load_per_mille() == 1000);
}

TEST_CASE("the load of many reads is the load of their sum") {
    const std::uint64_t one = forty.shortest(forty.polls[0]).us;
    CHECK(forty.load_per_mille() == (40 * one * 1000 + 3'499'999) / 3'500'000);
}

} // namespace bus_keep_alive_tests
