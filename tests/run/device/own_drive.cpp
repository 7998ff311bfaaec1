// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A user's own drive: the example's facade with the example's simulated winch on a virtual line. What the library
// promises of the drives that it has, it keeps for this one. Judged by the simulated winch and the frames.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

#include <examples/own_device/own_drive.hpp>
#include <examples/own_device/own_simulator.hpp>

namespace own_drive_tests {

using namespace servobus;
using winch::drive_state;
using winch::pulse;
using winch::r_per_min;

namespace {

struct rig {
    using line_type = scheduled_line<sim::virtual_line>;

    winch::simulated machine;
    sim::station<winch::simulated> station{machine, 5, 19200, milliseconds(1)};
    sim::virtual_line wire;
    line_type on{wire, modbus::timing_at(19200)};
    winch::drive<line_type> drum;

    explicit rig(supervision by = without_watchdog, std::uint64_t seed = 1)
        : wire{19200, seed}, drum{on, 5, by} {
        wire.attach(station);
    }
    rig(const rig&) = delete;

    void ready() {
        REQUIRE(drum.run(servobus::init{}));
        REQUIRE(drum.run(servobus::enable{}));
        REQUIRE(drum.state() == drive_state::enabled);
        REQUIRE(machine.is_energised());
    }
    void turn() {
        const duration idle = drum.step();
        wire.wait(idle.us == 0 ? microseconds(20) : idle);
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) turn();
    }
};

// A model is a constant of the program where its functions are.
static_assert(winch::model::blocks.image().contains(winch::position.address, 2));
static_assert(winch::model::kinds[winch::turn{}.prepare({}).then] == command_kind::endless_motion);
static_assert(winch::turn{601 * r_per_min}.prepare({drive_state::enabled}).refusal == errc::out_of_range);
static_assert(winch::prepare(servobus::move_to{2'000'000 * pulse}, {drive_state::enabled}).refusal ==
              errc::out_of_range);

} // namespace

TEST_CASE(
    "own drive: nothing moves before init and enable, and arguments are checked before anything is sent") {
    rig r;
    CHECK(r.drum.run(winch::turn{10 * r_per_min}).error() == errc::needs_init);
    CHECK(r.drum.run(servobus::move_to{100 * pulse}).error() == errc::needs_init);
    REQUIRE(r.drum.run(servobus::init{}));
    CHECK(r.drum.run(winch::turn{10 * r_per_min}).error() == errc::wrong_state);
    REQUIRE(r.drum.run(servobus::enable{}));
    CHECK(r.drum.run(winch::turn{61 * r_per_min}).error() == errc::out_of_range);
    CHECK(r.drum.run(servobus::move_to{1'000'001 * pulse}).error() == errc::out_of_range);
    CHECK(r.drum.run(servobus::wait_reached{}).error() == errc::wrong_state);
    CHECK(r.drum.run(servobus::move_to{1'000'001 * pulse}, servobus::wait_reached{}).how ==
          arrival_state::none);
    CHECK(r.drum.last().error() == errc::out_of_range);
    CHECK(r.machine.starts() == 0);
}

TEST_CASE(
    "own drive: a move ends at its target, and one that a fault interrupts says what is missing and why") {
    rig r;
    r.ready();
    CHECK(r.drum.run(servobus::move_to{12'000 * pulse}, servobus::wait_reached{}).how ==
          arrival_state::reached);
    CHECK(r.machine.place() == 12'000);
    REQUIRE(r.drum.run(servobus::move_to{-8'000 * pulse}));
    CHECK(r.drum.run(servobus::move_to{0 * pulse}).error() == errc::busy);
    r.loop(500);
    CHECK(r.drum.arrival().how == arrival_state::under_way);
    r.machine.raise_fault(7);
    r.loop(100);
    CHECK(r.drum.state() == drive_state::faulted);
    const winch::arrival a = r.drum.arrival();
    CHECK(a.how == arrival_state::stopped_short);
    CHECK(a.cause == stop_cause::fault);
    CHECK(a.missing.count() == -8'000 - r.machine.place());
    CHECK(r.drum.run(winch::turn{10 * r_per_min}).error() == errc::faulted);
    CHECK(r.drum.run(servobus::fault_reset{}).error() == errc::faulted);
    r.machine.end_fault_cause();
    REQUIRE(r.drum.run(servobus::fault_reset{}));
    CHECK(r.drum.state() == drive_state::disabled);
    REQUIRE(r.drum.run(servobus::enable{}));
}

TEST_CASE("own drive: a move that stands still for no stated reason is not reported as made") {
    rig r;
    r.ready();
    REQUIRE(r.drum.run(servobus::move_to{9'000 * pulse}));
    r.loop(300);
    r.machine.interrupt();
    CHECK(r.drum.run(servobus::wait_reached{}).error() == errc::stopped_short);
    CHECK(r.drum.arrival().missing.count() == 9'000 - r.machine.place());
}

TEST_CASE("own drive: a command timeout stops a turn, and cuts no move") {
    rig r{{.command_timeout = milliseconds(300)}};
    r.ready();
    REQUIRE(r.drum.run(winch::turn{30 * r_per_min}));
    r.loop(250);
    CHECK(r.machine.is_turning());
    r.loop(200);
    CHECK_FALSE(r.machine.is_turning());
    CHECK(r.machine.is_energised());
    const std::int32_t from = r.machine.place();
    REQUIRE(r.drum.run(servobus::move_to{(from + 10'000) * pulse}));
    r.loop(1'500);
    CHECK(r.machine.place() == from + 10'000);
    CHECK(r.drum.arrival().how == arrival_state::reached);
}

TEST_CASE("own drive: a restart shows within half a second, and nothing moves before init") {
    for (std::uint32_t after_ms = 0; after_ms < 600; after_ms += 50) {
        CAPTURE(after_ms);
        rig r;
        r.ready();
        r.loop(after_ms);
        r.machine.power_cycle();
        r.loop(600);
        CHECK(r.drum.state() == drive_state::needs_init);
        CHECK(r.drum.cause() == stop_cause::restart);
        CHECK(r.drum.run(winch::turn{10 * r_per_min}).error() == errc::needs_init);
        CHECK(r.machine.starts() == 0);
    }
}

TEST_CASE("own drive: on a line that loses frames a start is made at most once, and ok means that it was") {
    unsigned done = 0;
    unsigned struck = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        CAPTURE(seed);
        rig r{servobus::without_watchdog, seed};
        r.ready();
        r.loop(static_cast<std::uint32_t>(seed));
        r.wire.faults() = {.lost_request = 100, .lost_response = 150};
        const std::uint32_t before = r.machine.starts();
        const command_status ended = r.drum.run(servobus::move_to{3'000 * pulse});
        CHECK(r.machine.starts() <= before + 1);
        if (ended) CHECK(r.machine.starts() == before + 1);
        if (ended.outcome() == outcome::not_sent) CHECK(r.machine.starts() == before);
        if (ended) ++done;
        r.wire.faults() = {};
        struck += r.wire.struck();
        REQUIRE(r.drum.run(servobus::disable{}));
        CHECK_FALSE(r.machine.is_energised());
    }
    CHECK(done > 10);
    REQUIRE(struck > 30);
}

TEST_CASE("own drive: a stop is the next frame, and init begins with one") {
    rig r;
    r.ready();
    REQUIRE(r.drum.run(winch::turn{30 * r_per_min}));
    REQUIRE(r.drum.begin(servobus::wait_reached{}) == errc::wrong_state);
    REQUIRE(r.drum.begin(servobus::read_feedback{}) == errc::ok);
    REQUIRE(r.drum.begin(servobus::halt{}) == errc::ok);
    while (!r.drum.is_idle()) r.turn();
    REQUIRE(r.drum.last());
    CHECK_FALSE(r.machine.is_turning());
    REQUIRE(r.drum.run(winch::turn{30 * r_per_min}));
    winch::drive<rig::line_type> successor{r.on, 5};
    REQUIRE(successor.run(servobus::init{}));
    CHECK_FALSE(r.machine.is_energised());
}

namespace {
constexpr step hasty_steps[] = {steps::write<winch::control_word>(winch::control_code::off),
                                steps::same_drive(),
                                steps::write<winch::control_word>(winch::control_code::hold)};
/// A command that asks for the witness of a drive of which nothing is known.
struct hasty {
    constexpr winch::prepared_command prepare(const winch::cached_settings&) const {
        return {.steps = hasty_steps};
    }
};
} // namespace

TEST_CASE("own drive: a routine that asks for a witness before init ends there") {
    rig r;
    CHECK(r.drum.run(hasty{}).error() == errc::needs_init);
    CHECK(r.drum.last().step() == 1);
    CHECK_FALSE(r.machine.is_energised());
}

namespace {
constexpr node<winch::device> drum_node{5};
constexpr poll_plan drum_plan{
    modbus::timing_at(19200),
    controlled(drum_node, {.feedback = milliseconds(50), .command_timeout = milliseconds(300)}),
    cyclic<winch::load>(drum_node, milliseconds(200))};
} // namespace

TEST_CASE("own drive: on a bus it keeps its supervision, its cyclic reads and the age of what it says") {
    rig r;
    winch::drive<rig::line_type> drum{r.on, drum_node};
    auto all = make_bus<drum_plan>(r.on, drum);
    const auto loop = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000u;
        while (r.wire.time_us() < end) {
            const duration idle = all.step();
            r.wire.wait(idle.us == 0 ? microseconds(20) : idle);
        }
    };
    CHECK(drum.feedback(milliseconds(100)).error() == errc::needs_init);
    CHECK(all.latest<winch::load>(milliseconds(400)).error() == errc::needs_init);
    REQUIRE(all.run(drum, servobus::init{}));
    REQUIRE(all.run(drum, servobus::enable{}));
    REQUIRE(all.run(drum, winch::turn{30 * r_per_min}));
    loop(250);
    CHECK(r.machine.is_turning());
    loop(400);
    CHECK_FALSE(r.machine.is_turning()); // the command timeout
    CHECK(all.latest<winch::load>(milliseconds(400)));
    REQUIRE(drum.feedback(milliseconds(100)));
    CHECK(drum.feedback(milliseconds(100))->position.count() == r.machine.place());
    CHECK(all.run(drum, servobus::move_to{5'000 * pulse}, servobus::wait_reached{}).how ==
          arrival_state::reached);
    CHECK(r.machine.place() == 5'000);
    r.wire.wait(milliseconds(200));
    CHECK(drum.feedback(milliseconds(100)).error() == errc::timeout);
}

} // namespace own_drive_tests
