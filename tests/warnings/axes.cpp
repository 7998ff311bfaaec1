// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A program for a machine's geometry: moves of an axis, unwrapped positions, two wheels with a pose. This file is only
// compiled.
#include <servobus/axis/carried_move.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/axis/odometry.hpp>
#include <servobus/axis/unwrapped.hpp>

using namespace servobus;
using namespace servobus::literals;

namespace {
constexpr wheel screw = rolling(5.08_mm, counts_per_turn{1000}, gear{37, 10});
constexpr wheel tyre = rolling(diameter(207.6_mm), counts_per_turn{16384});
constexpr axle base = axle::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
constexpr differential speeds = differential::of(base, units::r_per_min / 10, 3000);
} // namespace

std::int64_t follow(odometry& machine, std::uint32_t left, std::uint32_t right, instant now) {
    if (!machine.update(left, right, now)) machine.set(plane_pose::at(1_m, 0_m, 90_mrad, now));
    const plane_pose& p = machine.pose();
    return p.x().count() + p.y().count() + p.x_mm().count() + p.y_mm().count() + p.heading().count();
}
odometry begin(std::uint32_t left, std::uint32_t right) {
    odometry machine{base};
    machine.start(left, right);
    machine.restart(left, right);
    return machine;
}
std::int32_t move(micrometres distance) {
    static carried_move moves{screw.counts_of_um(), screw.direction()};
    const result<planned_move> m = moves.plan(distance);
    if (!m) moves.reset();
    if (m) moves.commit(*m);
    return m ? m->counts : moves.rest();
}
std::int64_t unwrap(std::uint32_t raw) {
    static unwrapped_length position{screw.um_of_count(), screw.direction()};
    static unwrapped counts{count_direction::mirrored};
    counts.start(raw);
    if (!position.update(raw)) position.start(raw);
    return position.length().count() + position.counts() + counts.update(raw) + counts.counts();
}
std::int32_t drive(std::int32_t v, std::int32_t omega) {
    const wheel_speeds both =
        speeds.wheels({v * units::micrometre_per_second, omega * units::microradian_per_second});
    return both.is_limited ? 0 : both.left + both.right;
}
bool is_whole(std::int32_t counts) {
    constexpr scale um_of_count = screw.um_of_count();
    return um_of_count.is_exact(counts) && um_of_count.nearest(counts).value() <= um_of_count.most();
}
