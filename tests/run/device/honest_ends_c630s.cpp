// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The end of a move of a C630S that a stop input interrupts: the position of the simulated motor, and the
// result of `wait_standstill`. At standstill the drive shows "positioning completed" also after an emergency
// stop.
#include <doctest/doctest.h>

#include <string>

#include <tests/support/driven_c630s.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::c630s;
using rig = simulated::driven_c630s;

namespace {

constexpr distance way = 100'000 * reference_unit;

/// A move that FunIN.34 interrupts, and the result of `wait_standstill`.
struct cut_move {
    rig machine;
    routine_status end{};
    std::int64_t went = 0; ///< reference units, 10000 for a revolution of 131072 encoder counts
    bool has_alarm = false;
    bool is_still = false;
    bool has_begun = false;

    cut_move() {
        const bool is_ready = machine.make_ready() && machine.drive.run(enable{control_mode::position}) &&
                              machine.drive.run(segment{1, way, 600 * r_per_min, 100 * millisecond});
        const std::int64_t from = machine.model.position();
        if (!is_ready || !machine.drive.run(start_segment{1})) return;
        machine.run(250);
        has_begun = !machine.model.stands_still();
        machine.model.set_input(6, true); // DI6 is the emergency stop from the factory
        end = machine.drive.run(wait_standstill{});
        went = (machine.model.position() - from) * 10'000 / 131'072;
        has_alarm = machine.model.has_alarm(0x900);
        is_still = machine.model.stands_still();
    }
};

} // namespace

TEST_CASE("FunIN.34 interrupts a move: the motor stops before its target, with Er.900") {
    cut_move m;
    REQUIRE(m.has_begun);
    MESSAGE("the motor went " << m.went << " of " << way.count()
                              << " reference units; wait_standstill ended with: "
                                 ""
                              << std::string{text(m.end.error())});
    CHECK(m.is_still);
    CHECK(m.has_alarm);
    CHECK(m.went > 0);
    CHECK(m.went < way.count() / 2);
    // It stays there: the rest of the move is not made when the input becomes inactive.
    m.machine.model.set_input(6, false);
    const std::int64_t rested = m.machine.model.position();
    m.machine.run(2000);
    CHECK(m.machine.model.position() - rested <= 2);
}

TEST_CASE("wait_standstill does not return ok for a move that FunIN.34 interrupted") {
    const cut_move m;
    CHECK(m.end.error() == errc::stopped_short);
    const arrival there = m.machine.drive.arrival();
    CHECK(there.how == arrival_state::stopped_short);
    CHECK(there.cause == stop_cause::input);
    CHECK(there.missing.count() + m.went >= way.count() - 60); // within P05-21 of the command
    CHECK(there.missing.count() + m.went <= way.count() + 60);
}
