// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each operation of an axis in a separate function, `measured_...`: a conversion with its rest, unwrapping a position
// into micrometres, sine and cosine, updating a pose, a twist to two wheels. The compiler knows none of the inputs.
#include <cstdint>

#include <servobus/axis/axis_place.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>

#include "board.hpp"

namespace {

using namespace servobus;
using namespace servobus::literals;

constexpr feed tyre = rolling(652.3_mm, counts_per_turn{16384});
constexpr auto base = differential::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
constexpr auto belt = axis::of(tyre);

} // namespace

extern "C" {
extern constinit axis_place measured_position;
extern constinit odometry measured_pose;
constinit axis_place measured_position{belt};
constinit odometry measured_pose{base.base()};

[[gnu::noipa]] std::int32_t measured_convert(std::int32_t um, std::int32_t& rest) {
    return belt.counts_of(um * units::micrometre, rest).value_or(0);
}
[[gnu::noipa]] void measured_unwrap(std::uint32_t raw) { measured_position.follow(raw, 1); }
[[gnu::noipa]] detail::unit_vector measured_sine(std::uint32_t angle) {
    return detail::unit_vector_at(angle);
}
[[gnu::noipa]] bool measured_update(std::uint32_t left, std::uint32_t right, std::uint32_t now) {
    return measured_pose.update(left, right, {now});
}
[[gnu::noipa]] wheel_speeds measured_twist(twist t) { return base.wheels(t, 10, 3000); }

// The board runs the job twice. Three inputs of each: they differ in the corrections of a conversion and in the
// quadrant.
bool job() {
    std::int32_t rest = 0;
    bool is_right = measured_convert(652'300, rest) == 16'384 && rest == 0;
    is_right = is_right && measured_convert(-123'457, rest) == -3101 && measured_convert(99, rest) == 3;
    measured_position = axis_place{belt};
    measured_position.follow(0xFFFF'FF00, 1);
    measured_unwrap(0xFFFF'FF09);
    measured_unwrap(0x1000);
    measured_unwrap(0x0FF0);
    is_right = is_right && measured_position.length() == 162'438_um;
    is_right = is_right && measured_sine(0x1234'5678).sine > 0 && measured_sine(0x789A'BCDE).cosine < 0 &&
               measured_sine(0xC321'0987).sine < 0;
    measured_pose.set({});
    measured_pose.expect_arc({}); // the clock of each job begins at 0
    measured_pose.start(0, 0);
    is_right = is_right && measured_update(500, 0u - 400, 20'000) &&
               measured_update(1000, 0u - 1234, 40'000) && measured_update(700, 0u - 900, 60'000);
    is_right = is_right && measured_pose.pose().x() > 31_mm;
    const wheel_speeds slow = measured_twist({400_mm_per_s, 250_mrad_per_s});
    const wheel_speeds fast = measured_twist({-3200_mm_per_s, 900_mrad_per_s});
    return is_right && !slow.is_limited && slow.left == 310 && fast.is_limited && fast.left == -3000;
}
}
