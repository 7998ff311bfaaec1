// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wheel's way beside what its speeds allow: the bounds of each judgement, at rest, at one speed, between two,
// backward, and after more than 4 s; its bow and swing beside simulated speeds.
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/device/zlac8015d/wheel_step.hpp>

namespace wheel_step_tests {

using namespace servobus;
using zlac8015d::wheel_step;

namespace {

struct speeds {
    std::int16_t before, now; // 0.1 r/min
};
/// From 1000 counts on, of 4096 in a turn.
constexpr wheel_step step(std::int32_t moved, speeds at, duration between = milliseconds(20)) {
    const auto there = static_cast<std::uint32_t>(1000 + moved);
    return {{1000, at.before}, {there, at.now}, between, 4096};
}
/// How far from zero the wheel may be now.
constexpr bool comes_from_zero(std::int32_t farthest, speeds at, std::int32_t swing = 0) {
    const auto may = [at, swing](std::int32_t there) {
        const zlac8015d::wheel_image now{static_cast<std::uint32_t>(there), at.now};
        return wheel_step{{1000, at.before}, now, milliseconds(20), 4096}.may_come_from_zero(swing);
    };
    return may(farthest) && !may(farthest + 1) && may(-farthest) && !may(-farthest - 1);
}

} // namespace

static_assert(zlac8015d::wheel_image{}.position == 0 && zlac8015d::wheel_image{}.speed == 0);

TEST_CASE("a wheel at rest trembles by 5 counts") {
    constexpr speeds rest{0, 0};
    static_assert(comes_from_zero(5, rest));
    static_assert(step(5, rest).is_at_rest() && step(-5, rest).is_at_rest() && !step(6, rest).is_at_rest());
    static_assert(!step(0, {50, 0}).is_at_rest() && !step(0, {0, -50}).is_at_rest());
    CHECK(step(5, rest).is_at_rest());
}

TEST_CASE("60 r/min are 82 counts in 20 ms, forward and backward") {
    constexpr speeds forward{600, 600}, backward{-600, -600};
    static_assert(comes_from_zero(82 + 25, forward) && comes_from_zero(82 + 25, backward), "a quarter and 5");
    static_assert(comes_from_zero(82 + 25 + 32, forward, 2), "and 16 swings");
    static_assert(step(90, forward).excess() == 8 && step(70, forward).excess() == 12);
    static_assert(step(-90, backward).excess() == 8 && step(-70, backward).excess() == 12);
    static_assert(step(90, forward).bow() == 4 && step(82, forward).bow() == 0);
    static_assert(step(90, forward).farthest() == 90 && step(10, forward).farthest() == 82);
    CHECK(step(90, forward).excess() == 8);
}

TEST_CASE("a wheel that changes its speed has a way between both, and a bow") {
    static_assert(step(82, {600, 1200}).excess() == 0 && step(164, {600, 1200}).excess() == 0);
    static_assert(step(81, {600, 1200}).excess() == 1 && step(165, {1200, 600}).excess() == 1);
    static_assert(step(123, {600, 1200}).bow() == 10 && step(123, {1200, 600}).bow() == 10);
    static_assert(step(0, {600, -600}).bow() == 20 && step(0, {600, -600}).excess() == 0);
    static_assert(comes_from_zero(164 + 46, {600, 1200}) && comes_from_zero(164 + 46, {1200, 600}));
    CHECK(step(123, {1200, 600}).bow() == 10);
}

TEST_CASE("more than 4 s count as 4.2 s") {
    constexpr speeds forward{600, 600};
    constexpr std::int32_t way = 17'180; // in 2^22 us
    static_assert(step(way, forward, milliseconds(10'000)).excess() == 0);
    static_assert(step(way, forward, duration{1u << 22}).excess() == 0);
    static_assert(step(4096, forward, milliseconds(1000)).excess() == 0);
    CHECK(step(way + 7, forward, milliseconds(5000)).excess() == 7);
}

TEST_CASE("the bow bounds a wheel that goes once from one speed to another, the swing one that goes there "
          "and back") {
    std::mt19937 random{61};
    const auto below = [&random](std::int32_t most) {
        return static_cast<std::int32_t>(random() % static_cast<unsigned>(most));
    };
    for (int i = 0; i < 20'000; ++i) {
        const std::int32_t from = below(2400) - 1200, to = below(2400) - 1200; // 0.1 r/min
        const std::int32_t ms = 10 + below(300), changes_at = below(ms), takes = below(ms - changes_at) + 1;
        const std::int32_t by = 1 + below(8); // 0.1 r/min in a ms
        // Speeds in the middle of each millisecond: once there by a ramp, or a quarter faster, half slower, a quarter
        // faster.
        const auto once = [&](std::int32_t t) {
            const std::int32_t gone = t < changes_at ? 0 : t - changes_at > takes ? takes : t - changes_at;
            return from + static_cast<long double>(to - from) * gone / takes;
        };
        const auto there_and_back = [&](std::int32_t t) {
            const long double q = ms / 4.0L, at = t + 0.5L;
            return at < q ? from + by * at : at < 3 * q ? from + by * (2 * q - at) : from + by * (at - 4 * q);
        };
        const auto mean_distance = [&](const auto& speed_at, long double& way) {
            way = 0;
            for (std::int32_t t = 0; t < ms; ++t) way += speed_at(t) * 4096 / 600'000;
            long double at = 0, sum = 0;
            for (std::int32_t t = 0; t < ms; ++t) {
                at += speed_at(t) * 4096 / 600'000;
                const long double off = at - way * (t + 1) / ms;
                sum += off < 0 ? -off : off;
            }
            return sum / ms;
        };
        long double way = 0;
        const long double bow = mean_distance(once, way);
        const auto moved = static_cast<std::int32_t>(way);
        const speeds at{static_cast<std::int16_t>(from), static_cast<std::int16_t>(to)};
        CAPTURE(from);
        CAPTURE(to);
        CAPTURE(ms);
        CHECK(bow <= step(moved, at, milliseconds(static_cast<std::uint32_t>(ms))).bow() + 2);
        const long double swing = mean_distance(there_and_back, way);
        const std::int32_t bound = wheel_step::swing(static_cast<std::uint8_t>(by),
                                                     milliseconds(static_cast<std::uint32_t>(ms)), 4096);
        CAPTURE(by);
        CHECK(swing <= bound + 1);
        CHECK(bound <= swing * 1.1L + 2);
    }
}

} // namespace wheel_step_tests
