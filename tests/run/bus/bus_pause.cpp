// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus that looks for the next read only when one can be due: no read is late for that. And the RAM of a read.
#include <doctest/doctest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>

namespace bus_pause_tests {

using namespace servobus;
using tests::lift_node, tests::wheels_node;
using wire = scheduled_line<sim::virtual_line>;

// The lift has no facade here, so that there is always a read that is due later.
constexpr poll_plan seldom{modbus::timing_at(115200), controlled(wheels_node, unsupervised),
                           cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(5000)),
                           cyclic<yako::status_word>(lift_node, milliseconds(10'000))};
constexpr poll_plan often{modbus::timing_at(115200), cyclic<yako::status_word>(lift_node, milliseconds(100)),
                          cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(70))};

TEST_CASE("a read that is due while its drive is unknown is sent as soon as the drive is known") {
    tests::wheels_and_lift machine;
    wire on{machine.wire, modbus::timing_at(115200)};
    zlac8015d::drive wheels{on, wheels_node, by_plan};
    auto all = make_bus<seldom>(on, wheels);
    const auto step = [&] {
        const duration idle = all.step();
        on.port().wait(idle.us == 0 ? microseconds(1) : idle);
    };
    for (std::uint32_t round = 1; round <= 2; ++round) {
        CAPTURE(round);
        for (const std::uint64_t end = machine.wire.time_us() + 7'500'000; machine.wire.time_us() < end;)
            step();
        REQUIRE(all.count(0) == round - 1);
        REQUIRE(all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(60'000)).error() ==
                errc::needs_init);
        REQUIRE(wheels.begin(servobus::init{}) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !wheels.is_idle(); left.use()) step();
        REQUIRE(wheels.last());
        CHECK(all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(60'000)).error() ==
              errc::timeout); // no value of before
        for (const std::uint64_t end = machine.wire.time_us() + 30'000; machine.wire.time_us() < end;) step();
        CHECK(all.count(0) == round);
        CHECK(all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(1000)));
        machine.wheels_model.power_cycle();
        machine.wire.set_connected(0, false); // until the facade has noticed
        REQUIRE(wheels.begin(quick_stop{}) == errc::ok);
        while (wheels.state() != zlac8015d::drive_state::needs_init) step();
        machine.wire.set_connected(0, true);
    }
}

constexpr poll_plan steady{modbus::timing_at(115200), controlled(wheels_node, unsupervised),
                           cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(100)),
                           cyclic<yako::status_word>(lift_node, milliseconds(100))};

TEST_CASE(
    "G28: the reads of a drive that was absent have their rate again once it is known, whichever other node "
    "is still absent") {
    for (const std::uint32_t later_ms : {0u, 250u, 500u, 750u}) {
        CAPTURE(later_ms);
        tests::wheels_and_lift machine;
        wire on{machine.wire, modbus::timing_at(115200)};
        zlac8015d::drive wheels{on, wheels_node, by_plan};
        auto all = make_bus<steady>(on, wheels);
        const auto step = [&] {
            const duration idle = all.step();
            on.port().wait(idle.us == 0 ? microseconds(1) : idle);
        };
        const auto run_for = [&](std::uint32_t ms) {
            for (const std::uint64_t end = machine.wire.time_us() + ms * 1000u; machine.wire.time_us() < end;)
                step();
        };
        const auto init = [&] {
            REQUIRE(wheels.begin(servobus::init{}) == errc::ok);
            for (tests::loop_bound left{"the end of a command"}; !wheels.is_idle(); left.use()) step();
            REQUIRE(wheels.last());
        };
        init();
        run_for(500);
        REQUIRE(all.count(0) >= 4);
        machine.wire.set_connected(0, false);
        machine.wire.set_connected(1, false);
        while (wheels.state() != zlac8015d::drive_state::needs_init) step();
        run_for(later_ms);
        const std::uint32_t before = all.count(0);
        machine.wire.set_connected(0, true);
        init();
        run_for(350);
        CHECK(all.count(0) - before >= 3);
    }
}

TEST_CASE("G28: a drive that was absent, and whose port was lost meanwhile, is read as soon as it is known, "
          "though a search for the next read had found none for a second") {
    tests::wheels_and_lift machine;
    wire on{machine.wire, modbus::timing_at(115200)};
    zlac8015d::drive wheels{on, wheels_node, by_plan};
    auto all = make_bus<steady>(on, wheels);
    const auto step = [&] {
        const duration idle = all.step();
        on.port().wait(idle.us == 0 ? microseconds(1) : idle);
    };
    const auto run = [&](const auto& command) {
        REQUIRE(wheels.begin(command) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !wheels.is_idle(); left.use()) step();
        return wheels.last();
    };
    REQUIRE(run(init{}));
    REQUIRE(run(zlac8015d::watchdog{10 * units::second})); // it is known for so long
    machine.wire.set_connected(0, false);
    machine.wire.set_connected(1, false);
    for (const std::uint64_t end = machine.wire.time_us() + 3'000'000; machine.wire.time_us() < end;) step();
    const std::uint32_t asked = machine.wire.requests();
    for (tests::loop_bound left{"a read"}; machine.wire.requests() == asked; left.use()) step();
    machine.wire.pass(milliseconds(200)); // its end; the next one is due in a second
    for (int i = 0; i < 10; ++i) step();
    machine.wire.set_connected(0, true);
    machine.wire.unplug();
    CHECK(run(read_feedback{}).error() == errc::port_lost);
    machine.wire.plug();
    const std::uint32_t before = all.count(0);
    REQUIRE(run(init{}));
    for (const std::uint64_t end = machine.wire.time_us() + 150'000; machine.wire.time_us() < end;) step();
    CHECK(all.count(0) > before);
}

TEST_CASE("each read is sent when its period is over") {
    tests::wheels_and_lift machine;
    wire on{machine.wire, modbus::timing_at(115200)};
    auto all = make_bus<often>(on);
    std::uint32_t counts[2]{};
    std::uint64_t seen_at[2]{};
    while (machine.wire.time_us() < 20'000'000) {
        const duration idle = all.step();
        for (std::size_t i = 0; i < 2; ++i) {
            if (all.count(i) == counts[i]) continue;
            counts[i] = all.count(i);
            const std::uint64_t since_last = machine.wire.time_us() - seen_at[i];
            seen_at[i] = machine.wire.time_us();
            if (counts[i] < 4) continue; // a bus begins on a line of which nothing is known
            // The other read may be on the wire when this one is due, now or the last time.
            CHECK(since_last >= often.polls[i].period.us - 10'000);
            CHECK(since_last <= often.polls[i].period.us + 10'000);
        }
        on.port().wait(idle.us == 0 ? microseconds(1) : idle);
    }
    CHECK(counts[0] >= 199);
    CHECK(counts[1] >= 285);
}

template <const auto&... Rs, std::size_t... I> consteval auto reads_of(std::index_sequence<I...>) {
    return poll_plan{
        modbus::timing_at(115200),
        cyclic<Rs...>(node<yako::closed_loop::device>{std::uint8_t{I + 1}}, milliseconds(5000))...};
}
constexpr auto one = reads_of<yako::status_word>(std::make_index_sequence<1>{});
constexpr auto many = reads_of<yako::status_word>(std::make_index_sequence<31>{});
constexpr auto one_pair = reads_of<yako::actual_position>(std::make_index_sequence<1>{});
constexpr auto pairs = reads_of<yako::actual_position>(std::make_index_sequence<31>{});
// Its state has 20 bytes, or 28 with a word order; the values are apart.
static_assert((sizeof(bus<many, wire>) - sizeof(bus<one, wire>)) / 30 == 20 + 2);
static_assert((sizeof(bus<pairs, wire>) - sizeof(bus<one_pair, wire>)) / 30 == 28 + 4);

} // namespace bus_pause_tests
