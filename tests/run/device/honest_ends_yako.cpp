// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How a wait for the end of a move ends if the drive's own stop input has interrupted the move.
#include <doctest/doctest.h>

#include <tests/support/driven_yako.hpp>

namespace honest_ends_yako_tests {

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
    command_status stood;

    move_that_is_cut_short() {
        const motion_profile by{10 * r_per_min, 100 * millisecond, 100 * millisecond, 600 * r_per_min};
        REQUIRE(axis.drive.run(init{}));
        REQUIRE(axis.drive.run(disable{}));
        REQUIRE(axis.drive.run(set_input{input_terminal::x3, input_function::stop}));
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
    "G34: neither wait_standstill nor wait_reached returns ok for a move that the drive's stop "
    "input has interrupted, and arrival says how far the target is",
    A, closed_axis, open_axis) {
    move_that_is_cut_short<A> m;
    CHECK(m.stood.error() == errc::stopped_short);
    CHECK(m.axis.drive.run(wait_reached{}).error() == errc::stopped_short);
    const arrival a = m.axis.drive.arrival();
    CHECK(a.how == arrival_state::stopped_short);
    CHECK(a.missing.count() == m.ordered - m.axis.place());
}

// A motor that trembles may seem to be at a target so near. Where it comes to rest exactly shows whether it moved.
TEST_CASE_TEMPLATE(
    "G16, G34: a move of one to five pulses that the drive acknowledges and ignores is not done", A,
    closed_axis, open_axis) {
    for (std::int32_t way = -5; way <= 5; ++way) {
        if (way == 0) continue;
        CAPTURE(way);
        for (const bool is_ignored : {true, false}) {
            CAPTURE(is_ignored);
            A a;
            REQUIRE(a.drive.run(init{}));
            REQUIRE(a.drive.run(disable{}));
            REQUIRE(a.drive.run(set_input{input_terminal::x3, input_function::stop}));
            REQUIRE(a.drive.run(enable{}));
            a.model.set_input(3, is_ignored);
            const std::int64_t before = a.model.view().shaft;
            const command_status r =
                a.drive.run(move_by{way * pulse, motion_profile{0 * r_per_min, 10 * millisecond,
                                                                10 * millisecond, 60 * r_per_min}});
            a.run(200);
            CHECK(a.model.view().shaft == before + (is_ignored ? 0 : way));
            CHECK(r.error() == (is_ignored ? errc::not_executed : errc::ok));
        }
    }
}

} // namespace honest_ends_yako_tests
