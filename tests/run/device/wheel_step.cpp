// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A wheel's way beside what its speeds allow: the bounds of each judgement, at rest, at one speed, between two, backward, and
// after more than 4 s.
#include <cstdint>

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
constexpr bool is_even(std::int32_t lowest, std::int32_t highest, speeds at) {
    return step(lowest - 1, at).is_odd() && !step(lowest, at).is_odd() && !step(highest, at).is_odd() &&
           step(highest + 1, at).is_odd();
}
constexpr bool is_steady(std::int32_t lowest, std::int32_t highest, speeds at,
                         duration between = milliseconds(20)) {
    return !step(lowest - 1, at, between).is_steady() && step(lowest, at, between).is_steady() &&
           step(highest, at, between).is_steady() && !step(highest + 1, at, between).is_steady();
}
/// How far from zero the wheel may be now.
constexpr bool comes_from_zero(std::int32_t farthest, speeds at) {
    const auto may = [at](std::int32_t there) {
        const zlac8015d::wheel_image now{static_cast<std::uint32_t>(there), at.now};
        return wheel_step{{1000, at.before}, now, milliseconds(20), 4096}.may_come_from_zero();
    };
    return may(farthest) && !may(farthest + 1) && may(-farthest) && !may(-farthest - 1);
}

} // namespace

static_assert(zlac8015d::wheel_image{}.position == 0 && zlac8015d::wheel_image{}.speed == 0);

TEST_CASE("a wheel at rest trembles by 5 counts") {
    constexpr speeds rest{0, 0};
    static_assert(is_even(-5, 5, rest) && is_steady(-5, 5, rest) && comes_from_zero(5, rest));
    CHECK(is_even(-5, 5, rest));
}

TEST_CASE("60 r/min are 77 counts in 20 ms, forward and backward") {
    constexpr speeds forward{600, 600}, backward{-600, -600};
    static_assert(is_even(77 - 24, 77 + 24, forward) && is_even(-79 - 24, -79 + 24, backward), "a quarter");
    static_assert(is_steady(77 - 9, 77 + 9, forward) && is_steady(-79 - 9, -79 + 9, backward), "a sixteenth");
    static_assert(comes_from_zero(77 + 24, forward) && comes_from_zero(79 + 24, backward));
    CHECK(is_even(77 - 24, 77 + 24, forward));
}

TEST_CASE("a wheel that changes its speed has a way between both, and is steady within 2 r/min") {
    static_assert(is_even(77 - 43, 155 + 43, {600, 1200}) && is_even(77 - 43, 155 + 43, {1200, 600}));
    static_assert(is_even(-79 - 24, 77 + 24, {-600, 600}) && is_even(-79 - 24, 77 + 24, {600, -600}));
    static_assert(comes_from_zero(155 + 43, {600, 1200}) && comes_from_zero(155 + 43, {1200, 600}));
    static_assert(step(79, {600, 620}).is_steady() && step(79, {620, 600}).is_steady());
    static_assert(!step(79, {600, 621}).is_steady() && !step(79, {621, 600}).is_steady());
    CHECK(!step(116, {600, 1200}).is_steady());
}

TEST_CASE("more than 4 s count as 4 s") {
    constexpr speeds forward{600, 600};
    static_assert(is_steady(16'800 - 1055, 16'800 + 1055, forward, milliseconds(10'000)));
    static_assert(is_steady(16'800 - 1055, 16'800 + 1055, forward, duration{1u << 22}));
    static_assert(is_steady(4200 - 267, 4200 + 267, forward, duration{1u << 20}));
    CHECK(step(16'800, forward, milliseconds(5000)).is_steady());
}

} // namespace wheel_step_tests
