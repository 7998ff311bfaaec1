// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A machine with two wheels on one axle: a twist as their speeds, in the drives' counts. Where a wheel would exceed its
// limit, both slow down by one factor, so the machine keeps to its path. There is no dead band.
//
//     using namespace servobus::literals;
//     constexpr feed wheel = rolling(600_mm, counts_per_turn{16384});
//     constexpr auto base = differential::of({.left = wheel, .right = wheel, .track = 500_mm});
//     static_assert(base.wheels({500_mm_per_s, 1_rad_per_s}, 1, 300) == wheel_speeds{25, 75, false}); // r/min, of 300
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/axle.hpp>
#include <servobus/axis/detail/is_beyond.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant differential that calls it does not compile, and the error names the rule.
inline void a_turn_of_the_motor_travels_10_um_to_4_3_m() {}
} // namespace detail

/// The speed of a machine in the plane.
struct twist {
    /// Forward, in um/s, +-2147 m/s.
    quantity<unit{measure::micrometre_per_second}> speed{};
    /// To the left, in urad/s, +-2147 rad/s.
    quantity<unit{measure::microradian_per_second}> turn{};
};

void moves_or_energises(const twist*); // no take-over has it

/// The speeds of both wheels, in counts of the drives.
struct wheel_speeds {
    std::int32_t left = 0;
    std::int32_t right = 0;
    bool is_limited = false; ///< both were slowed down by one factor

    friend constexpr bool operator==(const wheel_speeds&, const wheel_speeds&) = default;
};

/// Two wheels on one axle, and their speeds at a twist.
class differential {
  public:
    /// Without wheels: their speeds are 0, and no drive is taken over with it, since it has no counts.
    constexpr differential() = default;

    /// What `axle::of` refuses does not compile.
    static consteval differential of(const axle::parts& p) {
        (void)axle::of(p);
        const result<differential> made = checked(p);
        if (!made) detail::a_turn_of_the_motor_travels_10_um_to_4_3_m();
        return *made;
    }
    /// The same of parts that are known at run time only. It divides.
    /// Errors: out_of_range (as `axle::checked`; a turn of a motor travels less than 10 um or more than 4.3 m).
    static constexpr result<differential> checked(const axle::parts& p) {
        const result<axle> on = axle::checked(p);
        if (!on) return on.error();
        if (!is_wheel(p.left) || !is_wheel(p.right)) return errc::out_of_range;
        const result<scale> left = p.left.speed_counts_of_um_per_s(units::r_per_min); // 6 .. 1.4e-5
        const result<scale> right = p.right.speed_counts_of_um_per_s(units::r_per_min);
        // Speed and turn together are at most twice as much, ten times as many counts, and must convert.
        const std::int32_t most = left->most() < right->most() ? left->most() : right->most();
        differential made;
        made.base_ = *on;
        made.left_ = *left;
        made.right_ = *right;
        made.most_ = static_cast<std::uint32_t>(most) / 20 - 16;
        return made;
    }

    constexpr const axle& base() const { return base_; }

    /// The speeds of the wheels at this twist, any of 32 bits, for drives whose register of speed counts
    /// `per_r_per_min` (1 .. 10) a r/min of the motor. No wheel exceeds `limit` (1 .. 32767 counts): limited after
    /// `speed` and `turn` are added, by one factor for both. Error: at most 1.5 counts and half a um/s, with
    /// wheels that are at most ten times as large as each other.
    constexpr wheel_speeds wheels(const twist& t, std::uint32_t per_r_per_min, std::uint32_t limit) const {
        std::int32_t speed = t.speed.count();
        std::int64_t side = std::int64_t{t.turn.count()} * base_.ratios().half_track; // 2^-29 um/s
        std::uint32_t halved = 0; // times, until the scales convert both
        while (detail::is_beyond(speed, most_) ||
               detail::is_beyond(static_cast<std::int32_t>(side >> 32), most_ / 8)) {
            speed /= 2;
            side /= 2;
            ++halved;
        }
        const auto turning = static_cast<std::int32_t>((side + (std::int32_t{1} << 28)) >> 29);
        const auto per = static_cast<std::int32_t>(per_r_per_min);
        wheel_speeds both{};
        both.left = counts(left_, base_.left(), (speed - turning) * per);
        both.right = counts(right_, base_.right(), (speed + turning) * per);
        const std::uint32_t left = size_of(both.left);
        const std::uint32_t right = size_of(both.right);
        const std::uint32_t most = left < right ? right : left;
        if (most > limit >> halved) {
            both.left = limited(both.left, left, most, limit);
            both.right = limited(both.right, right, most, limit);
            both.is_limited = true;
        } else {
            both.left *= std::int32_t{1} << halved;
            both.right *= std::int32_t{1} << halved;
        }
        return both;
    }

  private:
    // With more a scale would lose digits, with less a twist that is halved would.
    static constexpr bool is_wheel(const feed& w) {
        const std::uint64_t turns = w.ratio().motor_turns;
        return w.travel() >= 10'000 * turns && w.travel() <= 4'300'000'000 * turns;
    }
    static constexpr std::uint32_t size_of(std::int32_t v) {
        return static_cast<std::uint32_t>(v < 0 ? -v : v);
    }
    static constexpr std::int32_t counts(const scale& of, const feed& wheel, std::int32_t speed) {
        std::int32_t carry = 0;
        const bool is_mirrored = wheel.direction() == count_direction::mirrored;
        return of.converted(is_mirrored ? -speed : speed, carry);
    }
    // value * limit / most to the nearest, in 32 bits: the limit has 15. Bit by bit: a division takes 270 bytes on a
    // small core.
    static constexpr std::int32_t limited(std::int32_t value, std::uint32_t size, std::uint32_t most,
                                          std::uint32_t limit) {
        std::uint32_t cut = limit;
        if (size != most) {
            while (most >= std::uint32_t{1} << 17) {
                most >>= 1;
                size >>= 1;
            }
            std::uint32_t left = size * limit + most / 2;
            cut = 0;
            for (std::uint32_t part = most << 14; part >= most; part >>= 1) {
                cut *= 2;
                if (left < part) continue;
                left -= part;
                ++cut;
            }
        }
        return value < 0 ? -static_cast<std::int32_t>(cut) : static_cast<std::int32_t>(cut);
    }

    axle base_{};
    scale left_ = scale::zero(); // counts of r/min
    scale right_ = scale::zero();
    std::uint32_t most_ = 1'000'000; // um/s, of the twist's speed, and of the wheels by its turn
};

} // namespace servobus
