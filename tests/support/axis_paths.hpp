// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Paths of a machine with two wheels, and where they lead: each step is an arc, added up in long double. The heading is
// computed anew from the net counts. Tests of the odometry compare it with these.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <servobus/axis/odometry.hpp>

namespace axis_paths {

using std::int32_t;
using std::int64_t;
using std::uint32_t;
using number = long double;

inline constexpr number two_pi = 6.283185307179586476925286766559L;

/// um, and um of the track.
struct lengths {
    number left_count;
    number right_count;
    number track;
};
inline number um_of_count(const servobus::feed& w) {
    const number um = static_cast<number>(w.travel()) / 1000 / static_cast<number>(w.counts());
    return w.direction() == servobus::count_direction::forward ? um : -um;
}
inline lengths lengths_of(const servobus::axle& a) {
    return {um_of_count(a.left()), um_of_count(a.right()), static_cast<number>(a.track().count()) / 1000};
}

/// How far the odometry is off.
struct error {
    number um = 0;
    number rad = 0;
};

/// The same machine twice: by the odometry, and in long double.
class both {
  public:
    explicit both(const servobus::axle& of) : odometry_{of}, of_{lengths_of(of)} {
        odometry_.start(left_, right_);
    }

    /// Steps of the wheels in their counts. Returns false if the pose is not continuous.
    bool step(int32_t left, int32_t right) {
        left_ += static_cast<uint32_t>(left);
        right_ += static_cast<uint32_t>(right);
        net_left_ += left;
        net_right_ += right;
        const number l = static_cast<number>(left) * of_.left_count;
        const number r = static_cast<number>(right) * of_.right_count;
        const number half = (r - l) / of_.track / 2;
        const number chord = half == 0 ? 1 : std::sin(half) / half;
        x_ += (l + r) / 2 * chord * std::cos(heading_ + half);
        y_ += (l + r) / 2 * chord * std::sin(heading_ + half);
        way_ += std::fabs((l + r) / 2);
        heading_ = (static_cast<number>(net_right_) * of_.right_count -
                    static_cast<number>(net_left_) * of_.left_count) /
                   of_.track;
        time_.us += 20'000;
        return odometry_.update(left_, right_, time_);
    }

    error off() const {
        const servobus::plane_pose& p = odometry_.pose();
        const number x = std::ldexp(static_cast<number>(p.x_fine), -24) - x_;
        const number y = std::ldexp(static_cast<number>(p.y_fine), -24) - y_;
        number turned = std::ldexp(static_cast<number>(p.heading_fine), -64) - heading_ / two_pi;
        turned -= std::round(turned);
        return {std::hypot(x, y), std::fabs(turned * two_pi)};
    }
    number way() const { return way_; }
    const servobus::odometry& odometry() const { return odometry_; }

  private:
    servobus::odometry odometry_;
    lengths of_;
    uint32_t left_ = 0xFFFF'F000; // the registers wrap soon
    uint32_t right_ = 0x7FFF'F000;
    int64_t net_left_ = 0;
    int64_t net_right_ = 0;
    number x_ = 0;
    number y_ = 0;
    number heading_ = 0;
    number way_ = 0;
    servobus::instant time_{};
};

/// Turns lengths into counts without losing the rest, as a machine does that follows a path.
class wheel_at_speed {
  public:
    explicit wheel_at_speed(number um_of_count) : um_of_count_{um_of_count} {}
    int32_t counts(number um) {
        want_ += um / um_of_count_;
        const number step = std::round(want_ - static_cast<number>(counted_));
        counted_ += static_cast<int64_t>(step);
        return static_cast<int32_t>(step);
    }

  private:
    number um_of_count_;
    number want_ = 0;
    int64_t counted_ = 0;
};

} // namespace axis_paths
