// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A twist as the speeds of two wheels, in the drives' counts. Where a wheel would exceed its limit, both slow down by one
// factor, so the machine keeps to its path. There is no dead band.
//
//     using namespace servobus::literals;
//     constexpr wheel tyre = rolling(600_mm, counts_per_turn{16384});
//     constexpr axle base = axle::of({.left = tyre, .right = tyre, .track = 500_mm});
//     constexpr auto speeds = differential::of(base, units::r_per_min, 300); // at most 300 r/min
//     static_assert(speeds.wheels({500_mm_per_s, 1_rad_per_s}) == wheel_speeds{25, 75, false});
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/axle.hpp>
#include <servobus/axis/detail/is_beyond.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant that calls one does not compile, and the error names the rule.
inline void a_count_of_speed_is_of_r_per_min() {}
inline void a_limit_of_speed_is_1_to_32767_counts() {}
inline void a_limit_of_speed_is_below_67_m_per_s() {}
} // namespace detail

/// The speed of a machine in the plane.
struct twist {
    /// Forward, in um/s, +-2147 m/s.
    quantity<unit{measure::micrometre_per_second}> speed{};
    /// To the left, in urad/s, +-2147 rad/s.
    quantity<unit{measure::microradian_per_second}> turn{};
};

/// The speeds of both wheels, in counts of the drives.
struct wheel_speeds {
    std::int32_t left = 0;
    std::int32_t right = 0;
    bool is_limited = false; ///< both were slowed down by one factor

    friend constexpr bool operator==(const wheel_speeds&, const wheel_speeds&) = default;
};

/// Converts twists to speeds of the wheels of one axle. It is a constant.
class differential {
  public:
    /// For drives whose register of speed counts `count`, a part of r/min, and whose limit is so many counts (1 ..
    /// 32767), below 67 m/s of each wheel. Others do not compile.
    static consteval differential of(const axle& on, unit count, std::int32_t limit) {
        if (count.of != measure::r_per_min) detail::a_count_of_speed_is_of_r_per_min();
        if (limit < 1 || limit > 32'767) detail::a_limit_of_speed_is_1_to_32767_counts();
        return {on, count, limit};
    }

    /// The speeds of the wheels at this twist, any of 32 bits. No wheel exceeds its limit: limited after `speed` and
    /// `turn` are added, by one factor for both.
    /// Error: at most 1.5 counts, and 4 um/s where that is more.
    constexpr wheel_speeds wheels(twist t) const {
        std::int32_t speed = t.speed.count();
        std::int64_t side = std::int64_t{t.turn.count()} * half_track_; // 2^-29 um/s
        // Beyond `most_` a wheel is far above its limit, and half of the twist is too.
        while (detail::is_beyond(speed, most_) ||
               detail::is_beyond(static_cast<std::int32_t>(side >> 32), most_ / 8)) {
            speed /= 2;
            side /= 2;
        }
        const auto turning = static_cast<std::int32_t>((side + (1 << 28)) >> 29);
        wheel_speeds both{counts(left_, left_sign_, speed - turning),
                          counts(right_, right_sign_, speed + turning)};
        const std::uint32_t left = size_of(both.left);
        const std::uint32_t right = size_of(both.right);
        const std::uint32_t most = left < right ? right : left;
        if (most > limit_) {
            both.left = limited(both.left, left, most);
            both.right = limited(both.right, right, most);
            both.is_limited = true;
        }
        return both;
    }

  private:
    consteval differential(const axle& on, unit count, std::int32_t limit)
        : left_{on.left().speed_counts_of_um_per_s(count)}, right_{on.right().speed_counts_of_um_per_s(
                                                                count)},
          half_track_{on.ratios().half_track}, limit_{static_cast<std::uint32_t>(limit)},
          left_sign_{sign(on.left())}, right_sign_{sign(on.right())} {
        // Speed and turn together are at most twice as much, and must convert.
        std::int32_t most = 1 << 28;
        if (left_.most() < most) most = left_.most();
        if (right_.most() < most) most = right_.most();
        most_ = static_cast<std::uint32_t>(most) / 2 - 16;
        if (most < 64 || left_.nearest(most / 4 - 16).value() <= limit ||
            right_.nearest(most / 4 - 16).value() <= limit)
            detail::a_limit_of_speed_is_below_67_m_per_s();
    }
    static consteval std::int32_t sign(const wheel& w) {
        return w.direction() == count_direction::forward ? 0 : -1;
    }

    static constexpr std::uint32_t size_of(std::int32_t v) {
        return static_cast<std::uint32_t>(v < 0 ? -v : v);
    }

    static constexpr std::int32_t counts(const scale& of, std::int32_t sign, std::int32_t speed) {
        std::int32_t carry = 0;
        return of.converted((speed ^ sign) - sign, carry);
    }
    // value * limit / most, in 32 bits: the limit has 15.
    constexpr std::int32_t limited(std::int32_t value, std::uint32_t size, std::uint32_t most) const {
        std::uint32_t cut = limit_;
        if (size != most) {
            while (most >= 1u << 17) {
                most >>= 1;
                size >>= 1;
            }
            cut = (size * limit_ + most / 2) / most;
        }
        return value < 0 ? -static_cast<std::int32_t>(cut) : static_cast<std::int32_t>(cut);
    }

    scale left_;
    scale right_;
    std::uint32_t half_track_; // um of a wheel's way a urad, in parts of 2^29
    std::uint32_t limit_;
    std::uint32_t most_ = 0; // um/s, of the twist's speed, and of the wheels by its turn
    std::int32_t left_sign_; // 0, or -1 if mirrored
    std::int32_t right_sign_;
};

} // namespace servobus
