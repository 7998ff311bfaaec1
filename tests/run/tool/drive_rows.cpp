// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row of the tool's table of drives that lacks something does not compile; what it would be without is defined.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/catalogue.hpp>

#include <examples/servobus/tool.hpp>

namespace drive_rows_tests {
namespace {

using tool::device;
using tool::u16;

int simulate(const tool::simulation&) { return 0; }
std::vector<tool::alarm_row> alarms() { return {}; }
tool::repose at_rest(tool::session&) { return {}; }
constexpr bool stops(u16 address, u16) { return address == 7; }

constexpr device whole{.map = &servobus::zlac8015d::catalogue,
                       .simulate = simulate,
                       .alarms = alarms,
                       .at_rest = at_rest,
                       .stops = stops};

// devices.cpp has a static_assert of this for its table.
static_assert(is_complete_drive(whole));
static_assert(!is_complete_drive(device{}));
constexpr bool is_complete_without(auto member) {
    device d = whole;
    d.*member = nullptr;
    return is_complete_drive(d);
}
static_assert(!is_complete_without(&device::map));
static_assert(!is_complete_without(&device::simulate));
static_assert(!is_complete_without(&device::alarms));
static_assert(!is_complete_without(&device::at_rest));
static_assert(!is_complete_without(&device::stops));

TEST_CASE("a device without a rule of stops has no write that only stops it") {
    CHECK(whole.is_stop(7, 0));
    CHECK(!whole.is_stop(8, 0));
    const device of_file{.map = &servobus::zlac8015d::catalogue, .file = "meter.csv"};
    CHECK(!of_file.is_stop(7, 0));
    CHECK(of_file.word() == "meter.csv");
    CHECK(whole.word() == "zlac8015d");
}

} // namespace
} // namespace drive_rows_tests
