// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Plans of nodes with the limits of their profiles: two drives and a sensor, of which nothing is known, fit on a line.
#include <doctest/doctest.h>

#include <cstdint>

#include <servobus/any_device.hpp>
#include <servobus/bus/bus.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>

#include <tests/support/cell_sensor.hpp>

namespace default_nodes_tests {

using namespace servobus;
namespace sensor = tests::cell_sensor;

namespace {

constexpr node<zlac8015d::device> left{1}, right{2};
constexpr node<sensor::device> eye{9};
constexpr supervision supervised{.feedback = milliseconds(20), .command_timeout = milliseconds(500)};
constexpr auto quick = modbus::timing_at(115200);

// A drive has 32 ms to respond. A device of which nothing is known has 100 ms.
static_assert(zlac8015d::device::facts.limits.response == milliseconds(32));
static_assert(zlac8015d::device::facts.quarantine == milliseconds(100));
static_assert(yako::closed_loop::device::facts.limits.response == milliseconds(100));
static_assert(sensor::device::facts.limits.response == milliseconds(100));

// The watchdog from the factory takes a second.
constexpr poll_plan two_drives{quick, controlled(left, supervised).commands(milliseconds(50)),
                               controlled(right, supervised).commands(milliseconds(50))};
constexpr poll_plan prompt_nodes{
    quick, controlled(responds_within(left, milliseconds(30)), supervised).commands(milliseconds(50)),
    controlled(responds_within(right, milliseconds(30)), supervised).commands(milliseconds(50)),
    cyclic<sensor::distance>(responds_within(eye, milliseconds(30)), milliseconds(100))};
// Each node may be late by its limit and quarantine, one after the other: that takes longer than a second.
constexpr poll_plan two_drives_and_a_sensor{
    quick, controlled(left, supervised).commands(milliseconds(50)).keeps_alive(milliseconds(1300)),
    controlled(right, supervised).commands(milliseconds(50)).keeps_alive(milliseconds(1300)),
    cyclic<sensor::distance>(eye, milliseconds(100))};

} // namespace

TEST_CASE("two drives and a sensor with default nodes are a plan") {
    CHECK(two_drives.longest_gap(two_drives.controlled[0]) < milliseconds(938));
    CHECK(prompt_nodes.longest_gap(prompt_nodes.controlled[0]) < milliseconds(938));
    const auto& plan = two_drives_and_a_sensor;
    for (const controlled_node& d : plan.controlled) CHECK(plan.longest_gap(d) < d.keep_alive);
    // A drive's frames wait by the limits of the drives, not by the sensor's.
    CHECK(plan.longest_response() == milliseconds(32));
    CHECK(plan.longest_gap(plan.controlled[0]) < milliseconds(1180));
}

} // namespace default_nodes_tests
