// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The odometry: paths of a kilometre against long double, steps that are too long, restarts, poses that are set.
#include <cstdint>
#include <random>
#include <string>
#include <type_traits>

#include <doctest/doctest.h>

#include <servobus/axis/odometry.hpp>

#include "tests/support/axis_paths.hpp"

namespace odometry_tests {

using namespace servobus;
using namespace servobus::literals;
using axis_paths::both;
using axis_paths::number;
using std::int32_t;
using std::uint32_t;

constexpr feed tyre = rolling(652.3_mm, counts_per_turn{16384});
constexpr axle base = axle::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
constexpr axle uneven =
    axle::of({.left = rolling(652.3_mm, counts_per_turn{16384}),
              .right = rolling(diameter(207.9_mm), counts_per_turn{4096}, gear_ratio{37, 10}),
              .track = 487.3_mm});

static_assert(sizeof(odometry) <= 72);
static_assert(!std::is_constructible_v<odometry, axle>, "an axle that ends at the end of the line");

constexpr odometry started() {
    odometry o{base};
    o.start(0, 0);
    return o;
}
constexpr plane_pose after(uint32_t left, uint32_t right) {
    odometry o = started();
    (void)o.update(left, right, {7});
    return o.pose();
}
// A step of 0.163 m, the right wheel counts down
static_assert(after(4096, 0u - 4096).x() == 163'075_um && after(4096, 0u - 4096).y() == 0_um);
static_assert(after(0u - 4096, 4096).x() == -163'075_um && after(4096, 0u - 4096).time == instant{7});
static_assert(after(100, 100).heading().count() == -15'925 && after(100, 100).x() == 0_um,
              "in place, to the right");

// The steps that are not added
static_assert(after(208'473, 0u - 208'473).is_continuous && after(208'473, 0u - 208'473).x_mm() == 8300_mm);
static_assert(!after(208'474, 0u - 208'474).is_continuous && after(208'474, 0u - 208'474).x_mm() == 0_mm);
static_assert(!after(0u - 208'474, 208'474).is_continuous && !after(0, 208'474).is_continuous);
static_assert(after(0, 5023).is_continuous && after(0, 5023).heading() == -399'964_urad);
static_assert(!after(0, 5024).is_continuous && after(0, 5024).heading() == 0_urad);
static_assert(!after(0, 0u - 5024).is_continuous && !after(5024, 0).is_continuous);
static_assert(!after(0x8000'0000, 0x8000'0000).is_continuous &&
              !after(0x7FFF'FFFF, 0x8000'0001).is_continuous);

TEST_CASE("a step that is too long leaves the pose where it was, and the next one counts from its end") {
    odometry o = started();
    REQUIRE(o.update(4096, 0u - 4096, {1}));
    CHECK(!o.update(1'000'000, 0u - 1'000'000, {2}));
    CHECK(o.pose().x_mm() == 163_mm);
    CHECK(o.pose().time == instant{2});
    CHECK(!o.update(1'004'096, 0u - 1'004'096, {3}));
    CHECK(o.pose().x_mm() == 326_mm);
    o.set(plane_pose::at(1_m, 2_m, 0_urad, {4}));
    CHECK(o.pose().is_continuous);
    CHECK(o.update(1'008'192, 0u - 1'008'192, {5}));
    CHECK(o.pose().x_mm() == 1163_mm);
    CHECK(o.pose().y_mm() == 2_m);
}

TEST_CASE("a pose that is set has the time of the last update: that of the next step counts from there") {
    for (const bool is_old : {false, true}) {
        CAPTURE(is_old);
        odometry o = started();
        REQUIRE(o.update(4096, 0u - 4096, {90'000}));
        o.set(plane_pose::at(1_m, 2_m, 0_urad, {is_old ? 30'000u : 120'000u}));
        CHECK(o.pose().time == instant{90'000});
        odometry later = o;
        CHECK(o.update(8192, 0u - 8192, {190'000})); // 100 ms
        CHECK(o.pose().x_mm() == 1163_mm);
        CHECK_FALSE(later.update(8192, 0u - 8192, {190'001}));
        CHECK(later.pose().x_mm() == 1_m);
    }
}

TEST_CASE("start keeps the pose, restart says that it is not continuous") {
    odometry o{base};
    CHECK(o.update(77, 99, {1})); // without a start: the origin
    CHECK(o.pose().x() == 0_um);
    CHECK(o.update(77 + 4096, 99u - 4096, {2}));
    o.start(5, 6);
    CHECK(o.pose().is_continuous);
    CHECK(o.update(5, 6, {3}));
    CHECK(o.pose().x_mm() == 163_mm);
    o.restart(0, 0);
    CHECK(!o.pose().is_continuous);
    CHECK(!o.update(4096, 0u - 4096, {4}));
    CHECK(o.pose().x_mm() == 326_mm);
    plane_pose doubtful = o.pose();
    doubtful.heading_fine = 0x4000'0000'0000'0000;
    o.set(doubtful);
    CHECK(o.update(8192, 0u - 8192, {5}));
    CHECK(o.pose().x_mm() == 326_mm);
    CHECK(o.pose().y_mm() == 163_mm);
}

TEST_CASE("a step of more than 100 ms is added up to 1 mm and 1.5 mrad") {
    // 25 counts are 0.995 mm, 26 counts 1.035 mm; in place 9 counts of each wheel are 1.43 mrad, 10 counts 1.59 mrad.
    struct example {
        uint32_t left, right;
        std::uint32_t ms;
        bool is_added;
    };
    constexpr example examples[] = {
        {25, 0u - 25, 3000, true}, {26, 0u - 26, 100, true},
        {26, 0u - 26, 101, false}, {0u - 26, 26, 101, false},
        {9, 9, 3000, true},        {10, 10, 100, true},
        {10, 10, 101, false},      {0u - 10, 0u - 10, 101, false},
        {20, 0, 101, false},       {0, 20, 101, false},
    };
    for (const example& e : examples) {
        CAPTURE(e.left);
        CAPTURE(e.right);
        odometry o = started();
        CHECK(o.update(e.left, e.right, instant{e.ms * 1000}) == e.is_added);
    }
}

TEST_CASE("a path is near its arc if both bows turn the axle by little along the longer way") {
    std::mt19937 random{62};
    unsigned near = 0, all = 0;
    for (const axle* on : {&base, &uneven}) {
        const axis_paths::lengths of = axis_paths::lengths_of(*on);
        const odometry o{*on};
        const auto size = [](number length) { return length < 0 ? -length : length; };
        for (int i = 0; i < 50'000; ++i) {
            const auto any = [&] { return static_cast<int32_t>(random() % (1u << random() % 21)); };
            const int32_t bows[] = {any(), any()}, ways[] = {any(), any()};
            const number turned = (bows[0] * size(of.left_count) + bows[1] * size(of.right_count)) / of.track;
            const number left = ways[0] * size(of.left_count), right = ways[1] * size(of.right_count);
            const number beside = turned * (left < right ? right : left); // um
            const bool is_near = o.is_near_arc(bows[0], bows[1], ways[0], ways[1]);
            CAPTURE(bows[0]);
            CAPTURE(ways[0]);
            const bool is_short = ways[0] < 190'000 && ways[1] < 190'000 && turned < 1;
            if (is_short && beside < 745) CHECK(is_near);
            if (beside > 755) CHECK_FALSE(is_near);
            near += is_near;
            ++all;
        }
    }
    CHECK(near > all / 10);
    CHECK(near < all - all / 10);
}

TEST_CASE("a way that is known to be an arc is added, however long it took") {
    for (const bool is_known : {false, true}) {
        odometry o = started();
        constexpr instant late{600'000};
        if (is_known) o.expect_arc(late);
        CHECK(o.update(4096, 0u - 2048, late) == is_known); // 122 mm, 0.16 rad
        CHECK((o.pose().x() > 100_mm) == is_known);
    }
}

TEST_CASE("a pose that is set drops what is left of the steps before") {
    for (uint32_t i = 1; i < 50; ++i) {
        CAPTURE(i);
        odometry after_steps = started();
        REQUIRE(after_steps.update(i, 0u - i, {1}));
        after_steps.set(plane_pose{});
        odometry at_once{base};
        at_once.start(i, 0u - i);
        REQUIRE(after_steps.update(i + 1, 0u - i - 1, {2}));
        REQUIRE(at_once.update(i + 1, 0u - i - 1, {2}));
        CHECK(after_steps.pose().x_fine == at_once.pose().x_fine);
    }
}

TEST_CASE("a step that is not added leaves no rest either") {
    for (uint32_t i = 1; i < 50; ++i) {
        CAPTURE(i);
        odometry late = started();
        odometry told = started();
        REQUIRE(late.update(i, 0u - i, {1}));
        REQUIRE(told.update(i, 0u - i, {1}));
        CHECK_FALSE(late.update(i + 100, 0u - i - 100, {200'001})); // 4 mm in 0.2 s
        told.restart(i + 100, 0u - i - 100);
        (void)late.update(i + 101, 0u - i - 101, {200'002});
        (void)told.update(i + 101, 0u - i - 101, {200'002});
        CHECK(late.pose().x_fine == told.pose().x_fine);
    }
}

TEST_CASE("the heading depends on the net counts only, whatever the way") {
    std::mt19937 random{47};
    both steps{uneven};
    odometry once{uneven};
    once.start(0, 0);
    int32_t left = 0;
    int32_t right = 0;
    bool are_continuous = true;
    for (int i = 0; i < 20'000; ++i) {
        const auto l = static_cast<int32_t>(random() % 2001) - 1000;
        const auto r = static_cast<int32_t>(random() % 2001) - 1000;
        left += l;
        right += r;
        are_continuous &= steps.step(l, r);
    }
    REQUIRE(are_continuous);
    // The same counts in steps of another size
    uint32_t at_left = 0;
    uint32_t at_right = 0;
    while (at_left != static_cast<uint32_t>(left) || at_right != static_cast<uint32_t>(right)) {
        const auto way = [](uint32_t at, int32_t to) {
            const int32_t all = to - static_cast<int32_t>(at);
            return static_cast<uint32_t>(all > 500 ? 500 : all < -500 ? -500 : all);
        };
        at_left += way(at_left, left);
        at_right += way(at_right, right);
        REQUIRE(once.update(at_left, at_right, {}));
    }
    CHECK(once.pose().heading_fine == steps.odometry().pose().heading_fine);
}

// Within 20 um and 1e-9 rad in a kilometre.
void check_kilometre(const char* path, const both& b) {
    const axis_paths::error off = b.off();
    MESSAGE(std::string{path}, ": ", static_cast<double>(off.um), " um, ", static_cast<double>(off.rad),
            " rad");
    CHECK(off.um <= 20);
    CHECK(off.rad <= 1e-9);
    CHECK(b.odometry().pose().is_continuous);
}

// At 0.5 m/s, 50 readings a second. `turn`: rad a um.
void follow_circle(const char* path, const axle& on, number turn) {
    const axis_paths::lengths of = axis_paths::lengths_of(on);
    axis_paths::wheel_at_speed left{of.left_count};
    axis_paths::wheel_at_speed right{of.right_count};
    both b{on};
    for (int i = 0; i < 100'000; ++i) {
        const number side = 10'000 * turn * of.track / 2;
        (void)b.step(left.counts(10'000 - side), right.counts(10'000 + side));
    }
    CHECK(b.way() == doctest::Approx(1e9));
    check_kilometre(path, b);
}

TEST_CASE("a kilometre straight, and on a circle") {
    follow_circle("straight", base, 0);
    follow_circle("circle of 1 m", base, 1e-6L);
    follow_circle("two wheels of different size, straight", uneven, 0);
    follow_circle("two wheels of different size, circle of 3 m", uneven, -3.3e-7L);
}

TEST_CASE("a kilometre of each wheel in place") {
    axis_paths::wheel_at_speed left{axis_paths::lengths_of(base).left_count};
    axis_paths::wheel_at_speed right{axis_paths::lengths_of(base).right_count};
    both b{base};
    for (int i = 0; i < 100'000; ++i) (void)b.step(left.counts(-10'000), right.counts(10'000));
    check_kilometre("spinning", b);
}

TEST_CASE("a kilometre that wanders at 10 Hz") {
    for (const axle* on : {&base, &uneven}) {
        std::mt19937 random{48};
        const axis_paths::lengths of = axis_paths::lengths_of(*on);
        axis_paths::wheel_at_speed left{of.left_count};
        axis_paths::wheel_at_speed right{of.right_count};
        both b{*on};
        // 0.5 m/s and up to 1 rad/s
        for (int i = 0; i < 20'000; ++i) {
            const number turn = (static_cast<number>(random()) / 0xFFFF'FFFF - 0.5L) / 5;
            const number side = turn * of.track / 2;
            (void)b.step(left.counts(50'000 - side), right.counts(50'000 + side));
        }
        check_kilometre("wandering", b);
    }
}

TEST_CASE("a kilometre of slalom: all steps turn by 0.05 rad, to both sides") {
    for (const axle* on : {&base, &uneven}) {
        const axis_paths::lengths of = axis_paths::lengths_of(*on);
        axis_paths::wheel_at_speed left{of.left_count};
        axis_paths::wheel_at_speed right{of.right_count};
        both b{*on};
        for (int i = 0; i < 20'000; ++i) {
            const number side = (i % 4 < 2 ? 0.025L : -0.025L) * of.track;
            (void)b.step(left.counts(50'000 - side), right.counts(50'000 + side));
        }
        check_kilometre("slalom", b);
    }
}

TEST_CASE("any registers: no step is added that is too long to be true") {
    std::mt19937 random{49};
    odometry o = started();
    uint32_t left = 0;
    uint32_t right = 0;
    bool are_right = true;
    const axis_paths::lengths of = axis_paths::lengths_of(base);
    for (int i = 0; i < 100'000; ++i) {
        o.set({});
        const auto l = static_cast<int32_t>(static_cast<uint32_t>(random())) >> random() % 24;
        // As far as the left wheel, nearly, or anywhere
        const auto r = i % 2 == 0
                           ? -(l >> 1) - ((l + 1) >> 1) + static_cast<int32_t>(random() % 11'000) - 5500
                           : static_cast<int32_t>(static_cast<uint32_t>(random())) >> random() % 24;
        left += static_cast<uint32_t>(l);
        right += static_cast<uint32_t>(r);
        const bool is_continuous = o.update(left, right, {});
        const number turned =
            (static_cast<number>(r) * of.right_count - static_cast<number>(l) * of.left_count) / of.track;
        const auto is_in = [](number value, number most) { return value <= most && value >= -most; };
        const bool is_short = is_in(l, 208'473) && is_in(r, 208'473);
        if (is_short && is_in(turned, 0.39999L)) are_right &= is_continuous;
        if (!is_short || !is_in(turned, 0.40001L)) are_right &= !is_continuous && o.pose().x_fine == 0;
    }
    CHECK(are_right);
}

} // namespace odometry_tests
