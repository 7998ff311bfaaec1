// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Twists as speeds of two wheels: exact cases, and random ones against long double. long_runs.cpp has millions.
#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include <servobus/axis/differential.hpp>

#include "tests/support/axis_twists.hpp"

namespace differential_tests {

using namespace servobus;
using namespace servobus::literals;

constexpr feed wheel = rolling(600_mm, counts_per_turn{16384}); // 100 r/min are 1 m/s
constexpr auto base = differential::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});

constexpr wheel_speeds at(twist t) { return base.wheels(t, 1, 300); }

static_assert(at({}) == wheel_speeds{0, 0, false} && wheel_speeds{} == wheel_speeds{0, 0, false});
static_assert(at({1_m_per_s, 0_rad_per_s}) == wheel_speeds{100, -100, false});
static_assert(at({-1_m_per_s, 0_rad_per_s}) == wheel_speeds{-100, 100, false});
static_assert(at({0_m_per_s, 1_rad_per_s}) == wheel_speeds{-25, -25, false},
              "to the left: the right wheel runs forward");
static_assert(at({400_mm_per_s, 250_mrad_per_s}) == wheel_speeds{34, -46, false}); // 33.75, 46.25
static_assert(at({4_mm_per_s, 0_rad_per_s}) == wheel_speeds{0, 0, false} &&
                  at({6_mm_per_s, 0_rad_per_s}).left == 1,
              "no dead band: half a count");
static_assert(base.wheels({400_mm_per_s, 250_mrad_per_s}, 10, 3000) == wheel_speeds{338, -462, false});

// At the limit, one factor for both
static_assert(at({3_m_per_s, 0_rad_per_s}) == wheel_speeds{300, -300, false});
static_assert(at({3.02_m_per_s, 0_rad_per_s}) == wheel_speeds{300, -300, true});
static_assert(at({4_m_per_s, 8_rad_per_s}) == wheel_speeds{100, -300, true}); // 200, 600
static_assert(at({-4_m_per_s, 8_rad_per_s}) == wheel_speeds{-300, 100, true});
static_assert(at({0_m_per_s, -100_rad_per_s}) == wheel_speeds{300, 300, true});

// Any number of 32 bits
static_assert(at({2147_m_per_s, 0_rad_per_s}) == wheel_speeds{300, -300, true});
static_assert(at({-2'147'483'647_um_per_s, 2'147'483'647_urad_per_s}) == wheel_speeds{-300, 180, true});
static_assert(at({(-0x7FFF'FFFF - 1) * units::micrometre_per_second,
                  (-0x7FFF'FFFF - 1) * units::microradian_per_second}) == wheel_speeds{-180, 300, true});

// Also where a twist is halved until it converts: 120 m/s are not above a limit of 32767 r/min.
static_assert(base.wheels({120_m_per_s, 0_rad_per_s}, 1, 32'767) == wheel_speeds{12'000, -12'000, false});
static_assert(base.wheels({240_m_per_s, 40_rad_per_s}, 1, 32'767) == wheel_speeds{23'000, -25'000, false});
static_assert(base.wheels({330_m_per_s, 0_rad_per_s}, 1, 32'767) == wheel_speeds{32'767, -32'767, true});

TEST_CASE("speeds of wheels are the same if all of them is") {
    CHECK(wheel_speeds{1, 2, true} == wheel_speeds{1, 2, true});
    CHECK_FALSE(wheel_speeds{1, 2, true} == wheel_speeds{2, 2, true});
    CHECK_FALSE(wheel_speeds{1, 2, true} == wheel_speeds{1, 3, true});
    CHECK_FALSE(wheel_speeds{1, 2, true} == wheel_speeds{1, 2, false});
}

TEST_CASE("no wheel is above its limit, and each is within the bound of the scaled pair") {
    std::uint32_t seed = 50;
    for (const axis_twists::subject& s : axis_twists::subjects) {
        const axis_twists::judged all = axis_twists::judge_any(s, ++seed, 50'000);
        MESSAGE(std::string{s.name}, ": ", static_cast<double>(all.worst), " counts");
        CHECK(all.above == 0);
        CHECK(all.wrongly_limited == 0);
        CHECK(all.worst <= 1.5L);
        CHECK(all.limited > 1000);
        CHECK(all.limited < 49'000);
    }
}

} // namespace differential_tests
