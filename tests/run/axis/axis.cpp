// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Lengths and speeds of an axis as counts of its motor, and back: exact cases, and random ones against long double.
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/axis.hpp>

namespace axis_tests {

using namespace servobus;
using namespace servobus::literals;
using number = long double;

namespace {
constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
constexpr auto geared = axis::of(lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10}));
constexpr auto turned = axis::of(mirrored(lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10})));
constexpr auto belt = axis::of(rolling(120_mm, counts_per_turn{131'072}, gear_ratio{5, 1}));

constexpr micrometres_per_second um_s(std::int32_t n) { return micrometres_per_second{n}; }
} // namespace

static_assert(screw.counts_of(5_mm).value() == 1000 && screw.counts_of(-12.5_mm).value() == -2500);
static_assert(screw.counts_of(7_um).value() == 1 && screw.counts_of(2_um).value() == 0, "to the nearest");
static_assert(geared.counts_of(5.08_mm).value() == 3700 && turned.counts_of(5.08_mm).value() == -3700);
static_assert(geared.length_of(3700).value() == 5.08_mm && turned.length_of(3700).value() == -5.08_mm);
static_assert(screw.counts_of_motor_turn() == 1000 && belt.counts_of_motor_turn() == 131'072);
static_assert(!screw.is_mirrored() && turned.is_mirrored());

// 50 mm/s are 10 turns a second.
static_assert(screw.motor_speed_of(50_mm_per_s).value() == 600 * units::r_per_min);
static_assert(turned.motor_speed_of(50.8_mm_per_s).value() == -2220 * units::r_per_min);
static_assert(screw.speed_of(600 * units::r_per_min) == 50_mm_per_s);
static_assert(turned.speed_of(-2220 * units::r_per_min) == 50.8_mm_per_s);
static_assert(belt.motor_speed_of(1_m_per_s).value() == 2500 * units::r_per_min);

// In a drive's own counts, rounded once: 10'040 um/s are 120.48 r/min, and 10'042 um/s 120.504.
static_assert(screw.motor_counts_of(10'040_um_per_s, 1).value() == 120);
static_assert(screw.motor_counts_of(10'042_um_per_s, 1).value() == 121);
static_assert(screw.motor_counts_of(-10'040_um_per_s, 1).value() == -120);
static_assert(screw.motor_counts_of(-10'042_um_per_s, 1).value() == -121);
static_assert(screw.motor_counts_of(10'040_um_per_s, 10).value() == 1205);
static_assert(screw.motor_counts_of(10'040_um_per_s, 4).value() == 482); // 481.92
static_assert(turned.motor_counts_of(50.8_mm_per_s, 1).value() == -2220);
static_assert(turned.motor_counts_of(50.8_mm_per_s, 10).value() == -22'200);
static_assert(screw.motor_counts_of(um_s(214'748'364), 10).value() == 25'769'804); // 25'769'803.68
static_assert(screw.motor_counts_of(um_s(214'748'365), 1).error() == errc::out_of_range);
static_assert(screw.motor_counts_of(um_s(-214'748'365), 1).error() == errc::out_of_range);
static_assert(axis::of(lead(0.1_mm, counts_per_turn{100})).motor_counts_of(214_m_per_s, 10).error() ==
              errc::out_of_range);
constexpr auto of_tenths = axis::of(lead(0.6_mm, counts_per_turn{1000})); // a um/s is 0.1 r/min
static_assert(of_tenths.motor_counts_of(um_s(214'748'360), 10).value() == 214'748'360);
static_assert(of_tenths.motor_counts_of(um_s(-214'748'360), 10).value() == -214'748'360);
static_assert(of_tenths.motor_counts_of(um_s(214'748'361), 10).error() == errc::out_of_range);

// Beyond every count: refused, and never another number
static_assert(screw.counts_of(2147.5_m).error() == errc::out_of_range);
static_assert(screw.counts_of(-2147.5_m).error() == errc::out_of_range);
static_assert(belt.counts_of(400_m).error() == errc::out_of_range); // 2.2e9 counts
static_assert(screw.length_of(0x7FFF'FFFF).error() == errc::out_of_range);
static_assert(belt.motor_speed_of(um_s(0x7FFF'FFFF)).value() == motor_speed{53'687'091});
static_assert(axis::of(lead(0.1_mm, counts_per_turn{100})).motor_speed_of(um_s(0x7FFF'FFFF)).error() ==
              errc::out_of_range);
static_assert(belt.speed_of(motor_speed{0x7FFF'FFFF}).count() > 0, "limited");
static_assert(axis::of(rolling(4_m, counts_per_turn{100})).speed_of(motor_speed{-0x7FFF'FFFF}).count() ==
              -0x7FFF'FFFF);

TEST_CASE("what has no count, or no micrometre, is refused at run time too") {
    std::mt19937 random{3};
    const auto far = static_cast<std::int32_t>(0x7FFF'0000u + random() % 1000);
    constexpr auto fine = axis::of(lead(0.1_mm, counts_per_turn{100}));
    CHECK(screw.length_of(far).error() == errc::out_of_range);
    CHECK(fine.motor_speed_of(um_s(far)).error() == errc::out_of_range);
    CHECK(fine.motor_counts_of(um_s(far / 10 - 1000), 10).error() == errc::out_of_range);
    const auto over = static_cast<std::int32_t>(214'748'361u + random() % 4);
    CHECK(of_tenths.motor_counts_of(um_s(over), 10).error() == errc::out_of_range);
    CHECK(belt.counts_of(micrometres{far}).error() == errc::out_of_range);
}

TEST_CASE("random lengths and speeds, against long double") {
    std::mt19937 random{17};
    struct subject {
        const axis& is;
        number travel, counts; // um of a turn of the motor
    };
    for (const subject& s : {subject{screw, 5000, 1000}, subject{geared, 50800.0L / 37, 1000},
                             subject{turned, -50800.0L / 37, 1000}, subject{belt, 24'000, 131'072}}) {
        for (int i = 0; i < 200'000; ++i) {
            const auto um = static_cast<std::int32_t>(random()) >> (random() % 31);
            const number exact = static_cast<number>(um) / s.travel * s.counts;
            const result<std::int32_t> counts = s.is.counts_of(micrometres{um});
            CHECK(static_cast<bool>(counts) == (std::fabs(exact) < 2147483647.5L));
            if (counts) CHECK(std::fabs(static_cast<number>(*counts) - exact) <= 0.5000001L);
            if (counts) {
                const number back = static_cast<number>(*counts) / s.counts * s.travel;
                const result<micrometres> length = s.is.length_of(*counts);
                if (length) CHECK(std::fabs(static_cast<number>(length->count()) - back) <= 0.5000001L);
            }
            const number tenths = static_cast<number>(um) / s.travel * 600;
            const result<motor_speed> speed = s.is.motor_speed_of(um_s(um));
            const number slack = 0.5L + std::fabs(tenths) / (1 << 26);
            if (speed) CHECK(std::fabs(static_cast<number>(speed->count()) - tenths) <= slack);
            if (!speed) CHECK(std::fabs(tenths) > 2147000000.0L);
        }
    }
}

} // namespace axis_tests
