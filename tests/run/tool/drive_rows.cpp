// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A row of the tool's table of drives that lacks something does not compile; what a device of a file is without is
// defined.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/catalogue.hpp>

#include <examples/servobus/devices/registered_drive.hpp>

namespace drive_rows_tests {
namespace {

using tool::device;
using tool::known_drive;
using tool::u16;

int simulate(const tool::simulation&) { return 0; }
std::vector<tool::alarm_row> alarms() { return {}; }
tool::repose at_rest(tool::session&) { return {}; }
bool stops(u16 address, u16) { return address == 7; }
constexpr const servobus::catalogue& map = servobus::zlac8015d::catalogue;

// Each requirement but the first leaves one member out.
template <class Row>
concept is_whole = requires {
    Row{.map = map, .simulate = simulate, .alarms = alarms, .at_rest = at_rest, .stops = stops};
};
template <class Row>
concept may_lack_one = requires {
    Row{.simulate = simulate, .alarms = alarms, .at_rest = at_rest, .stops = stops};
}
|| requires { Row{.map = map, .alarms = alarms, .at_rest = at_rest, .stops = stops}; }
|| requires { Row{.map = map, .simulate = simulate, .at_rest = at_rest, .stops = stops}; }
|| requires { Row{.map = map, .simulate = simulate, .alarms = alarms, .stops = stops}; }
|| requires { Row{.map = map, .simulate = simulate, .alarms = alarms, .at_rest = at_rest}; };
static_assert(is_whole<known_drive>);
static_assert(!may_lack_one<known_drive>);

TEST_CASE("a device without a rule of stops has no write that only stops it") {
    const device whole =
        known_drive{.map = map, .simulate = simulate, .alarms = alarms, .at_rest = at_rest, .stops = stops};
    CHECK(whole.is_stop(7, 0));
    CHECK(!whole.is_stop(8, 0));
    CHECK(whole.word() == "zlac8015d");
    const device of_file{.map = &map, .file = "meter.csv"};
    CHECK(!of_file.is_stop(7, 0));
    CHECK(of_file.word() == "meter.csv");
}

} // namespace
} // namespace drive_rows_tests
