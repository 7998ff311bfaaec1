// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Compares the ZLAC8015D's `clamped_velocity` with arithmetic in long double, at every resolution and at many
// limits of the drive: the result is the nearest count, ties are rounded away from zero, and both wheels are
// slowed down by one factor.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include <servobus/device/zlac8015d/commands.hpp>

#include <tests/support/scripted_port.hpp>

namespace clamped_velocity_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;

namespace {

constexpr long double parts_of_r_per_min = 2520;

struct pair_of_counts {
    long double left;
    long double right;
};

// In the manual's r/min and counts: 2008h has whole r/min, 2088h takes at most 3000 counts.
pair_of_counts expected(speed left, speed right, std::uint16_t max_speed, std::uint16_t resolution) {
    const long double l = left.count() / parts_of_r_per_min * resolution;
    const long double r = right.count() / parts_of_r_per_min * resolution;
    const long double most = std::fmin(static_cast<long double>(max_speed) * resolution, 3000.0L);
    const long double fastest = std::fmax(std::fabs(l), std::fabs(r));
    if (fastest <= most) { // computed from whole numbers, so that ties are exact
        const auto count = [&](speed s) {
            return std::round(static_cast<long double>(s.count()) * resolution / parts_of_r_per_min);
        };
        return {count(left), count(right)};
    }
    const long double parts = std::fmax(std::fabs(static_cast<long double>(left.count())),
                                        std::fabs(static_cast<long double>(right.count())));
    return {std::round(static_cast<long double>(left.count()) * most / parts),
            std::round(static_cast<long double>(right.count()) * most / parts)};
}

cached_settings in_velocity_mode(std::uint16_t max_speed, std::uint16_t resolution) {
    return {.state = drive_state::enabled,
            .mode = operating_mode::velocity,
            .resolution = resolution,
            .max_speed = max_speed};
}

// Checks the words for 2088h and 2089h.
void check(speed left, speed right, std::uint16_t max_speed, std::uint16_t resolution) {
    const prepared_command o = clamped_velocity{left, right}.prepare(in_velocity_mode(max_speed, resolution));
    const pair_of_counts want = expected(left, right, max_speed, resolution);
    const auto l = static_cast<std::int16_t>(o.arguments[0]);
    const auto r = static_cast<std::int16_t>(o.arguments[1]);
    if (o.refusal == errc::ok && l == want.left && r == want.right) return;
    CAPTURE(left.count());
    CAPTURE(right.count());
    CAPTURE(max_speed);
    CAPTURE(resolution);
    CHECK(o.refusal == errc::ok);
    CHECK(l == want.left);
    CHECK(r == want.right);
}

} // namespace

TEST_CASE("a clamped speed becomes the nearest count, ties away from zero, in either direction") {
    const auto counts = [](speed left, speed right, std::uint16_t resolution = 1) {
        const prepared_command o = clamped_velocity{left, right}.prepare(in_velocity_mode(1000, resolution));
        REQUIRE(o.refusal == errc::ok);
        return std::pair{static_cast<std::int16_t>(o.arguments[0]),
                         static_cast<std::int16_t>(o.arguments[1])};
    };
    const auto tenths = part<10>(r_per_min);
    using both = std::pair<std::int16_t, std::int16_t>;
    CHECK(counts(19 * tenths, -19 * tenths) == both{2, -2}); // 1.9 r/min
    CHECK(counts(15 * tenths, -15 * tenths) == both{2, -2}); // a tie
    CHECK(counts(5 * tenths, -5 * tenths) == both{1, -1});
    CHECK(counts(14 * tenths, -14 * tenths) == both{1, -1});
    CHECK(counts(4 * tenths, -4 * tenths) == both{0, 0});
    CHECK(counts(19 * tenths, -19 * tenths, 10) == both{19, -19});
    CHECK(counts(19 * tenths, -19 * tenths, 2) == both{4, -4});        // 3.8 counts
    CHECK(counts(5 * tenths, -25 * tenths, 3) == both{2, -8});         // 1.5 and 7.5 counts
    CHECK(counts(9999 * tenths, 10000 * tenths) == both{1000, 1000});  // limited
    CHECK(counts(4000 * r_per_min, -1 * r_per_min) == both{1000, 0});  // scaled by a quarter: -0.25
    CHECK(counts(4000 * r_per_min, -2 * r_per_min) == both{1000, -1}); // scaled by a quarter: -0.5, a tie
}

TEST_CASE("S3: clamped speeds agree with arithmetic in long double, for many values, limits and "
          "resolutions") {
    tests::dice random{16};
    const std::uint16_t limits[]{1, 2, 3, 7, 60, 200, 299, 300, 301, 428, 429, 999, 1000};
    for (std::uint16_t resolution = 1; resolution <= 10; ++resolution) {
        const std::int32_t one = 2520 / resolution;
        for (const std::uint16_t limit : limits) {
            for (std::int32_t n = -7; n <= 7; ++n) { // around every half and whole count near zero
                for (std::int32_t off = -1; off <= 1; ++off) {
                    check(speed{n * one / 2 + off}, speed{-n * one / 2}, limit, resolution);
                    check(speed{0}, speed{limit * 2520 + n * one / 2 + off}, limit, resolution);
                }
            }
            for (int i = 0; i < 400; ++i) {
                const auto any = [&] {
                    const auto size = static_cast<std::int32_t>(random.next()); // 31 bits
                    const std::int32_t part = size >> random.below(31);
                    return speed{random.below(2) == 0 ? part : -part};
                };
                check(any(), any(), limit, resolution);
            }
            const speed most{0x7FFF'FFFF};
            const speed least{-0x7FFF'FFFF};
            check(most, least, limit, resolution);
            check(speed{limit * 2520}, most, limit, resolution);
            check(least, speed{1}, limit, resolution);
        }
    }
    // The lowest 32-bit value has no positive counterpart.
    const prepared_command o =
        clamped_velocity{speed{-0x7FFF'FFFF - 1}, speed{0x7FFF'FFFF}}.prepare(in_velocity_mode(1000, 1));
    CHECK(o.refusal == errc::ok);
    CHECK(o.arguments[0] == static_cast<std::uint16_t>(-1000));
    CHECK(o.arguments[1] == 1000);
}

static_assert(clamped_velocity{19 * part<10>(r_per_min), 0 * r_per_min}
                  .within({.resolution = 1, .max_speed = 100})
                  .left == 2 * r_per_min);

} // namespace clamped_velocity_tests
