// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Odometry: the pose of a machine with two wheels on one axle, from the position registers of their drives. One update
// for each feedback. It uses integers only; the pose that it keeps does not depend on how often it is read.
//
//     using namespace servobus::literals;
//     constexpr feed wheel = rolling(652.3_mm, counts_per_turn{16384});
//     constexpr axle base = axle::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});
//     static_assert([] { odometry o{base}; o.start(0, 0); return o.update(4096, 0u - 4096, {}) &&
//                        o.pose().x_mm() == 163_mm && o.pose().heading() == 0_urad; }());
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/axle.hpp>
#include <servobus/axis/detail/is_beyond.hpp>
#include <servobus/axis/detail/sine.hpp>
#include <servobus/axis/plane_pose.hpp>
#include <servobus/core/time.hpp>

namespace servobus {

/// Adds up the steps of two wheels. The heading depends on the net counts of the wheels only.
///
/// A step is what a wheel moves between two updates. Its path is taken as an arc. A step whose path is not known is not
/// added, and the pose is not continuous from then on:
/// - more than 8.3 m or 2^20 counts of a wheel, or a turn of more than 0.4 rad
/// - more than 100 ms with a way of more than 1 mm or a turn of more than 1.5 mrad, unless `expect_arc` was called
///
/// A restart of the drive is found only by such a step. A program that knows of one calls `restart`.
///
/// Error of the arithmetic in a kilometre of steps of up to 0.05 rad: 20 um and 1e-9 rad, with counts of 0.4 um and
/// more.
class odometry {
  public:
    /// Has no axle, until another one is assigned.
    constexpr odometry() = default;
    /// Begins at x 0, y 0, heading 0, with the first positions. `of` must outlive the odometry: a constant of the
    /// namespace does.
    constexpr explicit odometry(const axle& of) : axle_{&of} {}
    odometry(const axle&&) = delete;

    /// Takes the present positions as those of the present pose, which is kept, and stays as continuous as it is. The
    /// first time it becomes continuous.
    constexpr void start(std::uint32_t left, std::uint32_t right) {
        left_ = left;
        right_ = right;
        if (!is_started_) pose_.is_continuous = true;
        is_started_ = true;
    }

    /// Does so after the positions were lost, as by a restart of the drive: the pose is not continuous. The first time
    /// it is as `start`.
    constexpr void restart(std::uint32_t left, std::uint32_t right) {
        if (is_started_) pose_.is_continuous = false;
        start(left, right);
    }

    /// Sets the pose, which is continuous from then on. The next step begins where, and when, the last one has ended:
    /// the time of `to` is not used.
    constexpr void set(const plane_pose& to) {
        const instant was = pose_.time;
        pose_ = to;
        pose_.time = was;
        pose_.is_continuous = true;
        rest_ = 0;
    }

    /// States that the path until `now` is near an arc, however long the next step has taken.
    constexpr void expect_arc(instant now) { pose_.time = now; }
    /// True if the path of a step ends within 0.75 mm of its arc. A bow is the distance of a wheel from a steady way,
    /// as a mean over the time of the step; `farthest` is the longest way that a wheel has made. All are counts, 0 and
    /// more.
    constexpr bool is_near_arc(std::int32_t left_bow, std::int32_t right_bow, std::int32_t left_farthest,
                               std::int32_t right_farthest) const {
        const detail::axle_ratios& of = axle_->ratios();
        const auto most = static_cast<std::int32_t>(of.most_counts);
        if (left_bow > most || right_bow > most || left_farthest > most || right_farthest > most)
            return false;
        // The heading is wrong by as much as both bows turn the axle, all along the longer of both ways.
        const std::int64_t turned = left_bow * (magnitude(static_cast<std::int64_t>(of.left_turn)) >> 24) +
                                    right_bow * (magnitude(static_cast<std::int64_t>(of.right_turn)) >> 24);
        const std::int64_t left = left_farthest * magnitude(of.left_arc);
        const std::int64_t right = right_farthest * magnitude(of.right_arc);
        const auto way = static_cast<std::int32_t>((left < right ? right : left) >> 31); // 2^-8 um
        const std::int64_t theta = turned >> 8;                                          // 2^-32 turn
        constexpr std::uint32_t most_beside = 30'557; // 0.75 mm rad, in 2^-8 um turn
        return theta < std::int64_t{1} << 30 &&
               !detail::is_beyond(detail::high_product(way, static_cast<std::int32_t>(theta)), most_beside);
    }

    /// Adds the steps to these positions, which were read at `now`. The first update, without a `start`, adds none.
    /// If the step is not added, the pose stays where it was and is not continuous. Returns `is_continuous`.
    constexpr bool update(std::uint32_t left, std::uint32_t right, instant now) {
        const auto l = static_cast<std::int32_t>(left - left_);
        const auto r = static_cast<std::int32_t>(right - right_);
        const duration took = since(pose_.time, now);
        pose_.time = now;
        if (!is_started_) {
            start(left, right);
        } else {
            left_ = left;
            right_ = right;
            if (!move(l, r, took)) pose_.is_continuous = false;
        }
        return pose_.is_continuous;
    }

    /// The pose at the last update.
    constexpr const plane_pose& pose() const { return pose_; }

  private:
    constexpr bool move(std::int32_t l, std::int32_t r, duration took) {
        const detail::axle_ratios& of = axle_->ratios();
        if (detail::is_beyond(l, of.most_counts) || detail::is_beyond(r, of.most_counts)) return false;
        const std::int64_t left_arc = l * of.left_arc;
        const std::int64_t right_arc = r * of.right_arc;
        const auto difference =
            static_cast<std::int32_t>(right_arc >> 32) - static_cast<std::int32_t>(left_arc >> 32);
        if (detail::is_beyond(difference, static_cast<std::uint32_t>(of.most_difference))) return false;

        // The heading turns modulo 2^64. Half of the turn is the direction of the chord.
        const std::uint64_t turned = static_cast<std::uint64_t>(std::int64_t{l}) * of.left_turn +
                                     static_cast<std::uint64_t>(std::int64_t{r}) * of.right_turn;
        const auto theta = static_cast<std::int32_t>(static_cast<std::int64_t>(turned) >> 45); // 2^-19 turn
        // The arc in 2^-8 um; what is below goes into the next step.
        const std::int64_t arc = left_arc + right_arc + rest_;
        auto way = static_cast<std::int32_t>(arc >> 32);
        if (took > milliseconds(100) && is_long(way, theta)) return false;
        rest_ = static_cast<std::uint32_t>(arc);
        const auto half = static_cast<std::uint64_t>(static_cast<std::int64_t>(turned) >> 1);
        const detail::unit_vector at =
            detail::unit_vector_at(static_cast<std::uint32_t>((pose_.heading_fine + half) >> 32));
        pose_.heading_fine += turned;
        // The chord is shorter than the arc by theta^2 / 24: (2 pi)^2 / 24 is 1 + 165/256 + 3/8192, a trifle less here
        // for the next term.
        const std::uint32_t square = static_cast<std::uint32_t>(theta * theta) >> 6;
        const std::uint32_t shorter = square + (square * 165 >> 8) + (square >> 12) + (square >> 13);
        way -= detail::high_product(way, static_cast<std::int32_t>(shorter));
        pose_.x_fine = moved(pose_.x_fine, std::int64_t{way} * at.cosine >> 14);
        pose_.y_fine = moved(pose_.y_fine, std::int64_t{way} * at.sine >> 14);
        return true;
    }

    // A way of more than 1 mm, in 2^-8 um, or a turn of more than 1/4096, in 2^-19.
    static constexpr bool is_long(std::int32_t way, std::int32_t theta) {
        return detail::is_beyond(way, 256'000) || detail::is_beyond(theta, 128);
    }
    static constexpr std::int64_t magnitude(std::int64_t v) { return v < 0 ? -v : v; }
    // Wraps 549 km from the origin.
    static constexpr std::int64_t moved(std::int64_t from, std::int64_t by) {
        return static_cast<std::int64_t>(static_cast<std::uint64_t>(from) + static_cast<std::uint64_t>(by));
    }

    const axle* axle_ = nullptr;
    std::uint32_t left_ = 0;
    std::uint32_t right_ = 0;
    std::uint32_t rest_ = 0; // 2^-40 um
    bool is_started_ = false;
    plane_pose pose_{.is_continuous = false};
};

} // namespace servobus
