// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Why a command in the machine's units was refused: the states and settings in which it is possible, as of the drive's
// own command, or an error of its value.
#include <doctest/doctest.h>

#include <servobus/device/c630s/arguments.hpp>
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/device/yako/arguments.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/device/zlac8015d/arguments.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <tests/support/driven_c630s.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/simulated_yako.hpp>

namespace why_machine_units_tests {

using namespace servobus;
using namespace servobus::literals;

namespace {
constexpr feed wheel = rolling(600_mm, counts_per_turn{4096});
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});
constexpr auto belt = axis::of(wheel);
constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr auto ram = axis::of(lead(5_mm, counts_per_turn{10'000}));

constexpr drive_states enabled{drive_state::enabled};
} // namespace

TEST_CASE("why a twist was refused") {
    struct : simulated::driven_zlac8015d {
        zlac8015d::robot<line_type> robot{line, 1, base, unsupervised};
    } r;
    constexpr twist forward{1_m_per_s, 0_rad_per_s};
    CHECK(r.robot.begin(forward) == errc::needs_init);
    CHECK(why(r.robot, forward).error == errc::needs_init);
    REQUIRE(r.robot.run(init{}));
    CHECK(r.robot.begin(forward) == errc::wrong_state);
    refusal found = why(r.robot, forward);
    CHECK(found.error == errc::wrong_state);
    CHECK(found.state == drive_state::disabled);
    CHECK(found.states.is_empty() == false);
    REQUIRE(r.robot.run(zlac8015d::enable_in{zlac8015d::operating_mode::torque}));
    CHECK(r.robot.begin(forward) == errc::wrong_state);
    found = why(r.robot, forward);
    REQUIRE(found.unmet() != nullptr);
    CHECK(found.unmet()->address == zlac8015d::mode_of_operation.address);
    CHECK(found.unmet()->has(static_cast<unsigned>(zlac8015d::operating_mode::velocity)));
    CHECK(found.states == enabled);
    CHECK(why(r.robot, zlac8015d::torque{}).error == errc::ok); // the drive's own as before
}

TEST_CASE("why a command of a belt was refused") {
    struct : simulated::driven_zlac8015d {
        zlac8015d::axes<line_type> belts{line, 1, belt, belt, unsupervised};
    } r;
    REQUIRE(r.belts.run(init{}));
    REQUIRE(r.belts.run(enable{})); // velocity mode
    CHECK(r.belts.left().begin(move_by{1_mm}) == errc::wrong_state);
    const refusal found = why(r.belts.left(), move_by{1_mm});
    CHECK(found.error == errc::wrong_state);
    REQUIRE(found.unmet() != nullptr);
    CHECK(found.unmet()->address == zlac8015d::mode_of_operation.address);
    CHECK(found.unmet()->has(static_cast<unsigned>(zlac8015d::operating_mode::relative_position)));
    CHECK(why(r.belts.right(), velocity{1_um_per_s}).error == errc::out_of_range);
}

TEST_CASE("why a place or limits were refused") {
    struct : simulated::simulated_closed_loop {
        yako::closed_loop::axis_drive<line_type> lift{line, 1, screw};
    } r;
    REQUIRE(r.lift.run(init{}));
    REQUIRE(r.lift.run(disable{}));
    CHECK(r.lift.run(velocity{1_mm_per_s}).error() == errc::wrong_state);
    const refusal found = why(r.lift, velocity{1_mm_per_s});
    CHECK(found.error == errc::wrong_state);
    CHECK(found.states == enabled);
    CHECK(why(r.lift, limit_travel{2_mm, 1_mm}).error == errc::bad_argument);
    REQUIRE(r.lift.run(enable{}));
    CHECK(why(r.lift, velocity{2147_m_per_s}).error == errc::out_of_range);
    CHECK(r.lift.begin(move_to{1_mm}) == why(r.lift, move_to{1_mm}).error);

    struct : simulated::driven_c630s {
        c630s::axis_drive<line_type> press{line, 1, ram};
    } c;
    constexpr c630s::axis_segment down{1, 75_mm, 50_mm_per_s, 100_ms};
    CHECK(c.press.begin(down) == errc::needs_init);
    CHECK(why(c.press, down).error == errc::needs_init);
    CHECK(why(c.press, move_to{1_mm}).error != errc::ok);
}

} // namespace why_machine_units_tests
