// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Wheels and axles: the ratios that the compiler computes, against long double. tests/fail has what does not compile.
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <servobus/axis/axle.hpp>

namespace axle_tests {

using namespace servobus;
using namespace servobus::literals;

constexpr feed tyre = rolling(652.3_mm, counts_per_turn{16384});

// Lengths of any unit
static_assert(rolling(0.6523_m, counts_per_turn{16384}).travel() == 652'300'000);
static_assert(rolling(652'300_um, counts_per_turn{16384}).travel() == 652'300'000);
static_assert(tyre.counts() == 16384 && tyre.direction() == count_direction::forward);
static_assert(mirrored(tyre).direction() == count_direction::mirrored && mirrored(tyre).counts() == 16384);
static_assert(mirrored(mirrored(tyre)).direction() == count_direction::forward);

// Gears
constexpr feed lead_screw = lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10});
static_assert(lead_screw.um_of_count()->nearest(3700).value() == 5080 &&
              lead_screw.um_of_count()->is_exact(3700));
static_assert(lead_screw.counts_of_um()->nearest(5080).value() == 3700);
static_assert(lead_screw.counts_of_um()->numerator() == 185 &&
              lead_screw.counts_of_um()->denominator() == 254);

// The limits of what compiles
static_assert(rolling(4'294'967_um, counts_per_turn{1}).travel() == 4'294'967'000);
static_assert(rolling(1_um, counts_per_turn{1u << 28}).counts() == 1u << 28);
static_assert(rolling(1_um, counts_per_turn{1}, gear_ratio{65535, 1}).counts() == 65535);

// Speeds: 600 mm a turn are 100 r/min at 1 m/s.
constexpr feed round = rolling(600_mm, counts_per_turn{16384});
static_assert(round.speed_counts_of_um_per_s(units::r_per_min)->nearest(1'000'000).value() == 100);
static_assert(round.speed_counts_of_um_per_s(10 * unit{measure::r_per_min})->nearest(1'000'000).value() ==
              10);
static_assert(round.speed_counts_of_um_per_s(units::r_per_min / 10)->nearest(1'000'000).value() == 1000);
static_assert(round.um_per_s_of_speed_count(10 * unit{measure::r_per_min})->nearest(10).value() == 1'000'000);
static_assert(rolling(600_mm, counts_per_turn{16384}, gear_ratio{3, 1})
                  .speed_counts_of_um_per_s(units::r_per_min)
                  ->nearest(1'000'000)
                  .value() == 300);

// 207.6 mm * pi = 652.194'634'9 mm
static_assert(diameter(207.6_mm).count() == 652'194'630);
static_assert(diameter(1_m).count() == 3'141'592'650);
static_assert(diameter(1.36_m).count() == 4'272'566'010, "4.272'566'009 m");
static_assert(rolling(diameter(207.6_mm), counts_per_turn{16384}).um_of_count()->nearest(16384).value() ==
              652'195);

constexpr axle base = axle::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
static_assert(base.track() == 500_mm && base.left().travel() == 652'300'000);
static_assert(base.right().direction() == count_direction::mirrored);
static_assert(base.ratios().left_turn == base.ratios().right_turn, "both signs are turned");
static_assert(base.ratios().left_arc == -base.ratios().right_arc);
static_assert(base.ratios().most_counts == 208'473, "8.3 m");

constexpr axle of_fine_counts = axle::of({.left = rolling(100_mm, counts_per_turn{1u << 23}),
                                          .right = rolling(100.1_mm, counts_per_turn{1u << 23}),
                                          .track = 15.9_m});
static_assert(of_fine_counts.ratios().most_counts == 1u << 20);
constexpr feed finer = rolling(652.3_mm, counts_per_turn{120'000}); // 1.53 million counts in 8.3 m
static_assert(axle::of({.left = finer, .right = finer, .track = 500_mm}).ratios().most_counts == 1u << 20);

template <class Number> bool is_nearest(Number integer, long double exact) {
    // A double of 53 bits is exact enough for all but the last bits.
    return std::fabs(static_cast<long double>(integer) - exact) <= 0.51L + std::fabs(exact) * 1e-15L;
}

TEST_CASE("the ratios of an axle are the nearest integers") {
    const long double two_pi = 6.283185307179586476925286766559L;
    for (const axle* a : {&base, &of_fine_counts}) {
        const detail::axle_ratios& r = a->ratios();
        const long double track = static_cast<long double>(a->track().count());
        const auto um_of = [](const feed& w) {
            return static_cast<long double>(w.travel()) / static_cast<long double>(w.counts()) / 1000;
        };
        CHECK(is_nearest(static_cast<std::int64_t>(0 - r.left_turn),
                         um_of(a->left()) * 1000 / track / two_pi * std::ldexp(1.0L, 64)));
        CHECK(is_nearest(r.left_arc, um_of(a->left()) / 2 * std::ldexp(1.0L, 40)));
        CHECK(is_nearest(r.half_track, track / 1e9L / 2 * std::ldexp(1.0L, 29)));
        CHECK(is_nearest(r.most_difference + 0.5L, 0.2L * track / 1000 * 256));
    }
    CHECK(lead_screw.ratio().motor_turns == 37);
    const detail::axle_ratios& r = of_fine_counts.ratios();
    CHECK(r.right_arc * 1000 == doctest::Approx(static_cast<double>(r.left_arc) * 1001));
    CHECK(static_cast<double>(r.right_turn) * 1000 ==
          doctest::Approx(static_cast<double>(0 - r.left_turn) * 1001));
}

} // namespace axle_tests
