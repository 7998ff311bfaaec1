// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Literals of quantities: decimals become whole counts of a part of the unit, and units of one kind convert exactly.
// tests/fail has what does not compile.
#include <cstdint>
#include <string>
#include <type_traits>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/registers/literals.hpp>

namespace literals_tests {

using namespace servobus;
using namespace servobus::literals;

// Decimals
static_assert(std::is_same_v<decltype(12.5_r_per_min), quantity<unit{measure::r_per_min, 1, 10}>>);
static_assert((12.5_r_per_min).count() == 125);
static_assert(std::is_same_v<decltype(30_r_per_min), quantity<unit{measure::r_per_min}>>);
static_assert((12.50_r_per_min).count() == 125, "zeros at the end make no finer unit");
static_assert((12.0_r_per_min).count() == 12);
static_assert((.5_mm).count() == 5 && (5._mm).count() == 5 && (0_mm).count() == 0 && (0.0_mm).count() == 0);
static_assert((1'000.25_mm).count() == 100'025);
static_assert((0.0001_m).count() == 1);
static_assert((007.5_mm).count() == 75);
static_assert((2'147'483'647_um).count() == 2'147'483'647);
static_assert((-0.4_mm).count() == -4);

// Units of one kind
static_assert(0.4_mm == 400_um && 1_m == 1000_mm && 1_m == 1'000'000_um);
static_assert(1.5_m_per_s == 1500_mm_per_s && 1_mm_per_s == 1000_um_per_s);
static_assert(1_revolution == 360_degree && 0.25_revolution == 90_degree && 1_degree < 1_revolution);
static_assert(1_rad == 1000_mrad && 1_mrad == 1000_urad);
static_assert(0.25_rad_per_s == 250_mrad_per_s && 1_mrad_per_s == 1000_urad_per_s);
static_assert(1_s == 1000_ms && 1_ms == 1000_us);
static_assert(1.5_A == 1500_mA && 24_V == 24 * units::volt && 50_percent == 50 * units::percent);
static_assert((1.5_s).in(units::millisecond) == 1500);
static_assert((90_degree).rounded(units::revolution) == 0 && (270_degree).rounded(units::revolution) == 1);
static_assert((1_revolution).in(units::degree) == 360);

// Durations and times
constexpr duration as_duration(duration d) { return d; }
static_assert(as_duration(500_ms) == milliseconds(500) && as_duration(1.5_s) == milliseconds(1500));
static_assert(as_duration(250_us) == microseconds(250) && as_duration(-5_ms) == duration{});
static_assert(as_duration(5000_s).us == 0xFFFF'FFFF, "as long as a duration can be");
static_assert(quantity<unit{measure::millisecond}>{milliseconds(500)} == 500_ms);
static_assert(quantity<unit{measure::second}>{milliseconds(2000)} == 2_s);

// Kinds of their own
template <class A, class B>
concept comparable = requires(A a, B b) {
    a == b;
};
static_assert(comparable<decltype(1_mm), decltype(1_um)>);
static_assert(!comparable<decltype(1_rad), decltype(1_degree)>,
              "a radian is no rational part of a revolution");
static_assert(!comparable<decltype(1_mm), decltype(1_mm_per_s)>);
static_assert(!comparable<decltype(1_r_per_min), decltype(1_rad_per_s)>);

TEST_CASE("literals are where a program would write them") {
    zlac8015d::cached_settings known{.state = drive_state::enabled,
                                     .mode = zlac8015d::operating_mode::velocity};
    known.max_speed = 1000;
    const auto c = commands::prepared(velocity{30_r_per_min, -30_r_per_min}, known);
    CHECK(c.refusal == errc::ok);
    CHECK(c.arguments[0] == 30);
    CHECK(static_cast<std::int16_t>(c.arguments[1]) == -30);
    CHECK(commands::prepared(velocity{12.5_r_per_min, 0_r_per_min}, known).refusal == errc::inexact);
    CHECK(move_by{500_pulse}.way == 500 * units::pulse);
}

TEST_CASE("a time of a command is a quantity or a duration, a limit likewise") {
    const c630s::home a{30 * units::second};
    const c630s::home b{milliseconds(30'000)};
    const c630s::home c{30_s};
    CHECK(a.within == b.within);
    CHECK(a.within == c.within);
    CHECK(wait_standstill{5_s}.limit == milliseconds(5000));
    CHECK(wait_standstill{5 * units::second}.limit == milliseconds(5000));
    CHECK(wait_reached{milliseconds(5000)}.limit == milliseconds(5000));
    CHECK(zlac8015d::watchdog{milliseconds(500)}.limit == 500_ms);
}

TEST_CASE("each literal has its unit at run time too") {
    CHECK((7_us).in(units::microsecond) == 7);
    CHECK((7_ms).in(units::microsecond) == 7000);
    CHECK((7_s).in(units::millisecond) == 7000);
    CHECK((7_um).in(units::micrometre) == 7);
    CHECK((7_mm).in(units::micrometre) == 7000);
    CHECK((7_m).in(units::millimetre) == 7000);
    CHECK((7_um_per_s).in(units::micrometre_per_second) == 7);
    CHECK((7_mm_per_s).in(units::micrometre_per_second) == 7000);
    CHECK((7_m_per_s).in(units::millimetre_per_second) == 7000);
    CHECK((90_degree).in(units::degree) == 90);
    CHECK((2_revolution).in(units::degree) == 720);
    CHECK((7_urad).in(units::microradian) == 7);
    CHECK((7_mrad).in(units::microradian) == 7000);
    CHECK((7_rad).in(units::milliradian) == 7000);
    CHECK((7_urad_per_s).in(units::microradian_per_second) == 7);
    CHECK((7_mrad_per_s).in(units::microradian_per_second) == 7000);
    CHECK((7_rad_per_s).in(units::milliradian_per_second) == 7000);
    CHECK((7_r_per_min).in(units::r_per_min) == 7);
    CHECK((7_pulse).in(units::pulse) == 7);
    CHECK((7_mA).in(units::milliampere) == 7);
    CHECK((7_A).in(units::milliampere) == 7000);
    CHECK((7_V).in(units::volt) == 7);
    CHECK((7_percent).in(units::percent) == 7);
}

TEST_CASE("each new unit has a symbol") {
    CHECK(std::string{symbol(measure::micrometre_per_second)} == "um/s");
    CHECK(std::string{symbol(measure::milliradian)} == "mrad");
    for (auto m = static_cast<unsigned>(measure::count);
         m <= static_cast<unsigned>(measure::cubic_metre_per_hour); ++m)
        CHECK_FALSE(std::string{symbol(static_cast<measure>(m))}.empty());
}

} // namespace literals_tests
