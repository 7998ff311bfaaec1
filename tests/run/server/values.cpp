// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of a server whose values are floats, decimal digits, numbers with an offset, or none.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include <servobus/server/computed.hpp>
#include <servobus/server/row_values.hpp>
#include <servobus/server/stored_number.hpp>

#include <tests/support/every_value.hpp>

namespace served_value_tests {

using namespace servobus;
using namespace servobus::units;
namespace every_value = tests::every_value;
using device = every_value::device<word_order::low_first>;
using r = every_value::rows<device>;

namespace {
constexpr reading<r::voltage> measured() { return reading<r::voltage>{1.5f}; }
using values = row_values<r::target, r::gain, r::hour, r::torque, r::current, r::battery, r::ac_power, r::now,
                          r::currents, computed<r::voltage, measured>>;
} // namespace

TEST_CASE("a server's rows begin with their defaults, and hold what the device sets") {
    values v;
    CHECK(v.get<r::target>().value() == 21.0f);
    CHECK(*v.get<r::hour>() == 0);
    CHECK(v.get<r::battery>().count() == 0);
    CHECK(v.get<r::voltage>().value() == 1.5f);
    v.set<r::target>(clamped(450.0f));
    CHECK(v.get<r::target>().value() == 400.0f);
    CHECK(v.set<r::target>(checked(450.0f)).error() == errc::out_of_range);
    CHECK(v.set<r::target>(checked(20.25f)));
    CHECK(v.get<r::target>().value() == 20.25f);
    v.set<r::gain>(-0.5f);
    CHECK(v.get<r::gain>().value() == -0.5f);
    v.set<r::gain>(NAN);
    CHECK(!v.get<r::gain>().has_value());
    v.set<r::currents>(1, 2.5f);
    CHECK(v.get<r::currents>(1).value() == 2.5f);
    v.set<r::hour>(2359);
    CHECK(*v.get<r::hour>() == 2359);
    v.set<r::torque>(-100 * percent);
    CHECK(v.get<r::torque>().count() == -100);
    v.set<r::battery>(-40 * degree_celsius);
    CHECK(v.get<r::battery>().count() == -400);
    CHECK(v.set<r::battery>(checked(81 * degree_celsius)).error() == errc::out_of_range);
    v.set<r::ac_power>(-7 * watt);
    CHECK(v.get<r::ac_power>()->count() == -7);
    v.set<r::ac_power>(reading<r::ac_power>{});
    CHECK(!v.get<r::ac_power>());
    v.set<r::now>(every_value::phase::heating);
    CHECK(v.get<r::now>() == every_value::phase::heating);
    v.reset();
    CHECK(v.get<r::target>().value() == 21.0f);
}

} // namespace served_value_tests
