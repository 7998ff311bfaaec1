// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One program drives every drive: the common commands by one function, on all simulated drives and on the winch of the
// example. Judged by the simulated machine: energised, turning, with a fault.
#include <cstdint>
#include <functional>

#include <doctest/doctest.h>

#include <servobus/control/motor_drive.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

#include <examples/own_device/own_drive.hpp>
#include <examples/own_device/own_simulator.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_yako.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace common_commands_tests {

using namespace servobus;

using simulated_line = line<sim::virtual_line>;
static_assert(motor_drive<zlac8015d::drive<simulated_line>>);
static_assert(motor_drive<yako::closed_loop::drive<simulated_line>>);
static_assert(motor_drive<yako::open_loop::drive<simulated_line>>);
static_assert(motor_drive<c630s::drive<simulated_line>>);
static_assert(motor_drive<winch::drive<simulated_line>>);
static_assert(!motor_drive<client<simulated_line, zlac8015d::device>>);

static_assert(zlac8015d::drive<simulated_line>::traits.stops_without_line);
static_assert(!c630s::drive<simulated_line>::traits.stops_without_line);
static_assert(yako::closed_loop::drive<simulated_line>::traits.halts_in_position);

namespace {

// What only the simulated machine knows, and what only this drive's program can command.
template <class Drive> struct machine {
    Drive& drive;
    std::function<bool()> is_energised;
    std::function<bool()> stands;
    std::function<void()> have_fault;
    std::function<void()> end_fault; // its cause has ended; the drive still reports it
    std::function<bool()> turn;      // a command of the drive's own
    std::function<void(std::uint32_t)> pass;
};

template <motor_drive Drive> void drive_it(const machine<Drive>& m) {
    Drive& d = m.drive;
    // Nothing is known: only `init` and stops.
    CHECK(d.state() == drive_state::needs_init);
    CHECK(d.run(enable{}).error() == errc::needs_init);
    CHECK(d.run(fault_reset{}).error() == errc::needs_init);
    CHECK(d.run(read_feedback{}).error() == errc::needs_init);
    CHECK(d.run(wait_standstill{}).error() == errc::needs_init);
    CHECK(d.run(wait_reached{}).error() == errc::needs_init);
    CHECK(d.read().error() == errc::needs_init);
    CHECK(d.arrival().how == arrival_state::none);

    REQUIRE(d.run(init{}));
    CHECK(m.stands());
    // Some drives are energised when they are switched on.
    CHECK(d.state() == (m.is_energised() ? drive_state::enabled : drive_state::disabled));
    CHECK(d.run(wait_reached{}).error() == errc::wrong_state); // no move was commanded
    REQUIRE(d.run(disable{}));
    CHECK(d.state() == drive_state::disabled);
    CHECK_FALSE(m.is_energised());

    REQUIRE(d.run(enable{}));
    CHECK(d.state() == drive_state::enabled);
    CHECK(m.is_energised());
    REQUIRE(d.read());
    CHECK_FALSE(d.read()->has_fault());
    CHECK_FALSE(d.read()->is_moving());

    REQUIRE(m.turn());
    m.pass(300);
    CHECK_FALSE(m.stands());
    CHECK(d.read()->is_moving());
    CHECK(d.run(wait_standstill{milliseconds(200)}).error() == errc::not_reached);
    REQUIRE(d.run(halt{}));
    CHECK(d.run(wait_standstill{}));
    CHECK(m.stands());
    CHECK(m.is_energised());
    CHECK(d.cause() == stop_cause::command);

    // Stepped, a quick stop replaces a halt.
    REQUIRE(m.turn());
    REQUIRE(d.begin(halt{}) == errc::ok);
    REQUIRE(d.begin(quick_stop{}) == errc::ok);
    for (int i = 0; i < 1'000'000 && !d.is_idle(); ++i) {
        const duration idle = d.step();
        d.line().sleep(idle);
    }
    CHECK(d.last());
    CHECK(d.run(wait_standstill{}));
    CHECK(m.stands());
    REQUIRE(d.run(disable{}));
    CHECK(d.state() == drive_state::disabled);
    CHECK_FALSE(m.is_energised());

    REQUIRE(d.run(enable{}));
    m.have_fault();
    CHECK(d.read()->has_fault());
    CHECK(d.state() == drive_state::faulted);
    CHECK(d.cause() == stop_cause::fault);
    CHECK(d.run(enable{}).error() == errc::faulted);
    CHECK(d.run(disable{}));
    CHECK(d.run(fault_reset{}).error() == errc::faulted); // its cause lasts
    m.end_fault();
    REQUIRE(d.run(fault_reset{}));
    CHECK_FALSE(d.read()->has_fault());
    // Whether a reset energises a motor again is the drive's: a program that does not want it disables it.
    REQUIRE(d.run(disable{}));
    CHECK(d.state() == drive_state::disabled);
    CHECK_FALSE(m.is_energised());
}

} // namespace

TEST_CASE("the common commands drive a ZLAC8015D") {
    simulated::driven_zlac8015d r;
    drive_it(machine<decltype(r.drive)>{
        .drive = r.drive,
        .is_energised = [&] { return r.model.enabled(); },
        .stands = [&] { return r.model.stands_still(); },
        .have_fault = [&] { r.model.raise(zlac8015d::fault::overcurrent, zlac8015d::fault::none); },
        .end_fault = [&] { r.model.end_faults(); },
        .turn =
            [&] {
                return bool{r.drive.run(velocity{60 * units::r_per_min, 60 * units::r_per_min})};
            },
        .pass = [&](std::uint32_t ms) { r.wire.pass(milliseconds(ms)); },
    });
}

namespace {
template <class Axis> void drive_a_stepper() {
    Axis r;
    drive_it(machine<decltype(r.drive)>{
        .drive = r.drive,
        .is_energised = [&] { return r.model.enabled(); },
        .stands = [&] { return !r.is_moving(); },
        .have_fault = [&] { r.model.raise_alarm(1); },
        .end_fault = [&] { r.model.end_alarm(); },
        .turn = [&] { return bool{r.drive.run(velocity{60 * units::r_per_min})}; },
        .pass = [&](std::uint32_t ms) { r.wire.pass(milliseconds(ms)); },
    });
}
} // namespace

TEST_CASE("the common commands drive a YAKO of a closed loop") { drive_a_stepper<simulated::closed_axis>(); }
TEST_CASE("the common commands drive a YAKO of an open loop") { drive_a_stepper<simulated::open_axis>(); }

TEST_CASE("the common commands drive a C630S, once it is set up") {
    simulated::driven_c630s r;
    REQUIRE(r.make_ready());
    c630s::drive<simulated::driven_c630s::line_type> servo{r.line, 1, unsupervised}; // knows nothing yet
    drive_it(machine<decltype(servo)>{
        .drive = servo,
        .is_energised = [&] { return r.model.enabled(); },
        .stands = [&] { return r.model.stands_still(); },
        .have_fault = [&] { r.model.raise(0x620, true); },
        .end_fault = [&] { r.model.end_causes(); },
        .turn = [&] { return bool{servo.run(velocity{60 * units::r_per_min})}; },
        .pass = [&](std::uint32_t ms) { r.wire.pass(milliseconds(ms)); },
    });
}

TEST_CASE("the common commands drive a drive of one's own") {
    winch::simulated model;
    sim::station<winch::simulated> station{model, 5, 19200, milliseconds(1)};
    sim::virtual_line wire{19200, 1};
    wire.attach(station);
    simulated_line on{wire, modbus::timing_at(19200)};
    winch::drive<simulated_line> drum{on, 5, unsupervised};
    drive_it(machine<decltype(drum)>{
        .drive = drum,
        .is_energised = [&] { return model.is_energised(); },
        .stands = [&] { return !model.is_turning(); },
        .have_fault = [&] { model.raise_fault(3); },
        .end_fault = [&] { model.end_fault_cause(); },
        .turn = [&] { return bool{drum.run(winch::turn{60 * winch::r_per_min})}; },
        .pass = [&](std::uint32_t ms) { wire.pass(milliseconds(ms)); },
    });
}

} // namespace common_commands_tests
