// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program for a machine's geometry: moves and positions of an axis, two wheels with a pose. This file is only compiled.
#include <servobus/axis/axis_place.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>

using namespace servobus;
using namespace servobus::literals;

namespace {
constexpr feed screw = lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10});
constexpr feed tyre = rolling(diameter(207.6_mm), counts_per_turn{16384});
constexpr auto base = differential::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
constexpr auto slide = axis::of(mirrored(screw));
} // namespace

std::int64_t follow(odometry& machine, std::uint32_t left, std::uint32_t right, instant now) {
    if (!machine.update(left, right, now)) machine.set(plane_pose::at(1_m, 0_m, 90_mrad, now));
    const plane_pose& p = machine.pose();
    return p.x().count() + p.y().count() + p.x_mm().count() + p.y_mm().count() + p.heading().count();
}
odometry begin(std::uint32_t left, std::uint32_t right) {
    odometry machine{base.base()};
    machine.start(left, right);
    machine.restart(left, right);
    return machine;
}
std::int32_t move(axis_place& at, micrometres way) {
    std::int32_t rest = 0;
    const result<std::int32_t> counts = at.plan(way, rest);
    if (counts) at.keep(rest);
    return counts.value_or(slide.counts_of(way).value_or(0));
}
std::int64_t unwrap(axis_place& at, std::uint32_t raw) {
    at.follow(raw, 1);
    return at.is_known() ? at.length().count() : at.geometry().most_counts();
}
std::int32_t drive(std::int32_t v, std::int32_t omega) {
    const wheel_speeds both =
        base.wheels({v * units::micrometre_per_second, omega * units::microradian_per_second}, 10, 3000);
    return both.is_limited ? 0 : both.left + both.right;
}
std::int32_t drive(std::int32_t v) {
    const result<motor_speed> to = slide.motor_speed_of(v * units::micrometre_per_second);
    return to ? slide.speed_of(*to).count() : 0;
}
bool is_whole(std::int32_t counts) {
    constexpr scale um_of_count = screw.um_of_count();
    return um_of_count.is_exact(counts) && um_of_count.nearest(counts).value() <= um_of_count.most();
}
