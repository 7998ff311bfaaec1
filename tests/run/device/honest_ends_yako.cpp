// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a wait for the end of a move ends if the drive's own stop input has interrupted the move.
#include <doctest/doctest.h>

#include <tests/support/yako_axis.hpp>

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;
using simulated::closed_axis;
using simulated::open_axis;

namespace {

/// A move of 10000 pulses that an input stops, and a `wait_standstill` that waits for its end.
template <class A> struct move_that_is_cut_short {
    static constexpr std::int32_t ordered = 10'000;

    A axis;
    routine_status stood;

    move_that_is_cut_short() {
        const motion_profile by{10 * r_per_min, 100 * millisecond, 100 * millisecond, 600 * r_per_min};
        REQUIRE(axis.drive.run(init{}));
        REQUIRE(axis.drive.run(release{}));
        REQUIRE(axis.drive.run(set_input{input::x3, input_function::stop}));
        REQUIRE(axis.drive.run(enable{}));
        REQUIRE(axis.drive.run(move_by{ordered * pulse, by}));
        REQUIRE(axis.drive.begin(wait_standstill{}) == errc::ok);
        while (axis.place() < 2570) axis.turn(); // the ramp takes another 500 pulses
        axis.model.set_input(3, true);
        axis.finish();
        stood = axis.drive.last();
    }
};

} // namespace

TEST_CASE_TEMPLATE("a stop input ends a move before its target, and the drive shows it", A, closed_axis,
                   open_axis) {
    move_that_is_cut_short<A> m;
    CHECK_FALSE(m.axis.is_moving());
    CHECK(m.axis.model.enabled());
    CHECK(m.axis.model.alarm() == 0);
    CHECK(m.axis.place() > 2570);
    CHECK(m.axis.place() < 3600);
    m.axis.run(2000);
    const auto seen = m.axis.drive.read();
    REQUIRE(seen);
    CHECK(seen->inputs.x3);
    CHECK(seen->position.count() == m.axis.place());
    MESSAGE("stopped by its input at ", m.axis.place(), " of ", m.ordered, " pulses");
}

TEST_CASE_TEMPLATE(
    "G34: neither wait_standstill nor until_arrived returns ok for a move that the drive's stop "
    "input has interrupted, and arrival says how far the target is",
    A, closed_axis, open_axis) {
    move_that_is_cut_short<A> m;
    CHECK(m.stood.error() == errc::stopped_short);
    CHECK(m.axis.drive.run(until_arrived{}).error() == errc::stopped_short);
    const arrival a = m.axis.drive.arrival();
    CHECK(a.how == arrival_state::stopped_short);
    CHECK(a.missing.count() == m.ordered - m.axis.place());
}
