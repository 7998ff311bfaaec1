// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D whose positions are followed as 64-bit counts: they do not wrap, and go on from their last value when the
// drive has counted from elsewhere. It converts between counts and the framework's units, rad and rad/s.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

namespace servobus_ros2_control {

inline constexpr double rad_per_turn = 6.283185307179586;

/// One wheel, as the URDF states it.
struct wheel {
    std::uint32_t counts_per_turn = 4096;
    bool is_mirrored = false; ///< its motor is turned round: it counts down when the robot goes forward

    double sign() const { return is_mirrored ? -1.0 : 1.0; }
    double rad_of(std::int64_t counts) const {
        return sign() * rad_per_turn * static_cast<double>(counts) / counts_per_turn;
    }
    /// `tenths`: counts of 0.1 r/min.
    double rad_per_s_of(std::int32_t tenths) const { return sign() * rad_per_turn * tenths / 600.0; }
};

/// Makes one command of the speeds of both wheels, in rad/s. A pair that is too fast slows down by one factor: here
/// where it exceeds the type of a speed, and in the command where it exceeds the drive's limit.
inline servobus::zlac8015d::clamped_velocity velocity_of(const wheel (&wheels)[2], double left,
                                                         double right) {
    using servobus::zlac8015d::speed;
    constexpr double parts = 2520 * 60 / rad_per_turn; // of a speed in a rad/s
    constexpr double most = 2e9;
    const double fastest = std::max(std::abs(left), std::abs(right));
    const double factor = fastest > most / parts ? most / fastest : parts;
    const auto speed_of = [&](const wheel& w, double rad_per_s) {
        return speed{static_cast<std::int32_t>(std::lround(w.sign() * rad_per_s * factor))};
    };
    return {speed_of(wheels[0], left), speed_of(wheels[1], right)};
}

/// The model of the drive: each feedback counts once.
class wheels_model : public servobus::zlac8015d::model {
  public:
    constexpr void note(const servobus::block_feedback& seen, const settings& known) {
        if (known.state == servobus::drive_state::needs_init) return; // counted from elsewhere
        const bool is_same = is_known_ && seen.epoch == epoch_;
        for (std::size_t i = 0; i < 2; ++i) {
            const std::uint16_t* const at =
                seen.words + image::place_of<servobus::zlac8015d::left_actual_position> + 2 * i;
            const servobus::u32 now =
                servobus::join_words(at[0], at[1], servobus::zlac8015d::device::facts.word_order);
            if (is_same) counts_[i] += static_cast<std::int32_t>(now - last_[i]);
            last_[i] = now;
        }
        if (is_known_ && !is_same) ++gaps_;
        is_known_ = true;
        epoch_ = seen.epoch;
    }

    /// Counts since the first feedback.
    constexpr std::int64_t counts(std::size_t wheel) const { return counts_[wheel]; }
    /// How often the counts went on from their last value without the way between: after a restart of the drive, after
    /// each take-over but the first.
    constexpr std::uint32_t gaps() const { return gaps_; }
    /// Goes on from the counts of another object, before the first feedback.
    constexpr void go_on_from(const wheels_model& before) {
        counts_[0] = before.counts_[0];
        counts_[1] = before.counts_[1];
        gaps_ = before.gaps_ + (before.is_known_ ? 1u : 0u);
    }

  private:
    std::int64_t counts_[2]{};
    servobus::u32 last_[2]{};
    std::uint32_t gaps_ = 0;
    std::uint16_t epoch_ = 0;
    bool is_known_ = false;
};

/// The drive with its followed wheels.
template <class Line> class wheel_drive : public servobus::zlac8015d::basic_drive<Line, wheels_model> {
    using base = servobus::zlac8015d::basic_drive<Line, wheels_model>;

  public:
    using base::base;
    constexpr const wheels_model& followed() const { return this->model(); }
    constexpr void go_on_from(const wheels_model& before) { this->model().go_on_from(before); }
};

} // namespace servobus_ros2_control
