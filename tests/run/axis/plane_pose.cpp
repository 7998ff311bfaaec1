// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A pose in um, mm and urad: rounding, the ends of the ranges, and the heading's wrap.
#include <cmath>
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include <servobus/axis/plane_pose.hpp>

namespace plane_pose_tests {

using namespace servobus;
using namespace servobus::literals;
using std::int64_t;
using std::uint64_t;

constexpr plane_pose fine(int64_t x, int64_t y, uint64_t heading) { return {x, y, heading, {}, true}; }

static_assert(plane_pose{}.x_fine == 0 && plane_pose{}.y_fine == 0 && plane_pose{}.heading() == 0_urad &&
              plane_pose{}.is_continuous);
static_assert(plane_pose::at(1_um, -1_um, 0_urad).x() == 1_um &&
              plane_pose::at(1_um, -1_um, 0_urad).y() == -1_um);
static_assert(plane_pose::at(1_um, 2_um, 3_urad, {4}).time == instant{4});
static_assert(plane_pose::at(549'755_m, -549'755_m, 0_urad).x() == 549'755_m);
static_assert(plane_pose::at(549'756_m, 0_um, 0_urad).x().count() == (int64_t{1} << 39) - 1, "limited");
static_assert(plane_pose::at(-549'756_m, 0_um, 0_urad).x().count() == 1 - (int64_t{1} << 39));

static_assert(plane_pose::at(0_um, 0_um, 0_urad).is_continuous);

// mm
static_assert(plane_pose::at(1499_um, -1499_um, 0_urad).x_mm() == 1_mm);
static_assert(plane_pose::at(1500_um, -1501_um, 0_urad).x_mm() == 2_mm);
static_assert(plane_pose::at(0_um, -1501_um, 0_urad).y_mm() == -2_mm);
static_assert(plane_pose::at(0_um, -1499_um, 0_urad).y_mm() == -1_mm);
static_assert(plane_pose::at(549'755_m, -549'755_m, 0_urad).x_mm() == 549'755_m);
static_assert(fine(-0x7FFF'FFFF'FFFF'FFFF - 1, 0, 0).x_mm().count() == -549'755'814);

// The heading, in (-pi, pi]
static_assert(fine(0, 0, 0x8000'0000'0000'0000).heading() == 3'141'593_urad);
static_assert(fine(0, 0, 0x7FFF'FFFF'FFFF'FFFF).heading() == 3'141'593_urad);
static_assert(fine(0, 0, 0x8000'0100'0000'0000).heading() == -3'141'592_urad);
static_assert(fine(0, 0, 0x4000'0000'0000'0000).heading() == 1'570'796_urad);
static_assert(fine(0, 0, 0xC000'0000'0000'0000).heading() == -1'570'796_urad);
static_assert(plane_pose::at(0_um, 0_um, 7_rad).heading() == 716'815_urad);
static_assert(plane_pose::at(0_um, 0_um, -7_rad).heading() == -716'815_urad);

TEST_CASE("millimetres are the nearest ones") {
    std::mt19937_64 random{45};
    bool are_nearest = true;
    for (int i = 0; i < 100'000; ++i) {
        const auto x = static_cast<int64_t>(random()) >> random() % 40;
        // In um first: x = um * 2^24 + below
        const int64_t um = x >> 24;
        const int64_t below = x & 0xFF'FFFF;
        int64_t mm = um >= 0 ? um / 1000 : -((999 - um) / 1000);
        const int64_t rest = ((um - mm * 1000) << 24) + below;
        if (rest >= int64_t{500} << 24) ++mm;
        are_nearest &= fine(x, -1, 0).x_mm().count() == mm && fine(0, x, 0).y_mm().count() == mm;
        are_nearest &= fine(x, 0, 0).x().count() == um && fine(0, x, 0).y().count() == um;
    }
    CHECK(are_nearest);
}

TEST_CASE("a pose is limited to 549 km, and faces -pi as pi") {
    std::mt19937 random{5};
    const std::int64_t far = 600'000'000'000 + static_cast<std::int64_t>(random() % 1000);
    const plane_pose p = plane_pose::at(micrometres{far}, micrometres{-far}, plane_pose::microradians{0});
    CHECK(p.x().count() == 549'755'813'887);
    CHECK(p.y().count() == -549'755'813'887);
    plane_pose back;
    back.heading_fine = 0x8000'0000'0000'0000u + random() % 1000;
    CHECK(back.heading().count() == 3'141'593);
}

TEST_CASE("microradians are the nearest ones, there and back") {
    std::mt19937_64 random{46};
    const long double turn = 6'283'185.307179586476925286766559L;
    bool are_nearest = true;
    for (int i = 0; i < 100'000; ++i) {
        const uint64_t heading = random();
        const long double exact =
            static_cast<long double>(static_cast<int64_t>(heading)) * std::ldexp(turn, -64);
        const int urad = fine(0, 0, heading).heading().count();
        are_nearest &= std::fabs(static_cast<long double>(urad) - exact) < 0.504L && urad >= -3'141'592 &&
                       urad <= 3'141'593;
        are_nearest &= plane_pose::at(0_um, 0_um, plane_pose::microradians{urad}).heading().count() == urad;
    }
    CHECK(are_nearest);
}

} // namespace plane_pose_tests
