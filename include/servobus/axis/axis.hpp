// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An axis: converts lengths and speeds of a machine to the counts of its motor and back. Programs that move something
// by a screw, a belt or a rack give one to the facade of its drive.
//
//     constexpr auto slide = axis::of(lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10}));
//     static_assert(slide.counts_of(5.08_mm).value() == 3700); // 3.7 turns of the motor
//     static_assert(slide.length_of(-3700).value() == -5.08_mm);
//     static_assert(slide.speed_of(370 * part<10>(units::r_per_min)) == 847_um_per_s);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/is_beyond.hpp>
#include <servobus/axis/feed.hpp>
#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>

namespace servobus {

/// A speed of a machine in um/s, +-2147 m/s.
using micrometres_per_second = quantity<unit{measure::micrometre_per_second}, std::int32_t>;
/// A speed of a motor in 0.1 r/min.
using motor_speed = quantity<units::r_per_min / 10, std::int32_t>;

/// The ratios of an axis.
class axis {
    // In front: clang 14 does not find it in constants otherwise.
    template <class Convert>
    constexpr result<std::int32_t> counts_of(micrometres length, Convert&& convert) const {
        const std::int64_t um = length.count();
        if (um > 0x7FFF'FFFF || um < -0x7FFF'FFFF) return errc::out_of_range;
        const result<std::int32_t> counts = convert(static_cast<std::int32_t>(um));
        if (!counts) return counts.error();
        return *counts * sign_;
    }

  public:
    /// Refuses what it is asked to convert. Where an axis was refused itself, this is left, and no drive is taken over
    /// with it, since it has no counts.
    constexpr axis() = default;

    /// A feed that is too fine for a scale does not compile.
    static consteval axis of(const feed& by) {
        const result<axis> made = checked(by);
        if (!made) detail::a_scale_in_lowest_terms_is_below_2_32_over_at_most_2_29();
        return *made;
    }
    /// The same of a feed that is known at run time only. It divides.
    /// Errors: out_of_range (a feed of nothing, or one that is too fine for a scale).
    static constexpr result<axis> checked(const feed& by) {
        constexpr unit tenth = units::r_per_min / 10;
        const result<scale> um_of_count = by.um_of_count();
        const result<scale> counts_of_um = by.counts_of_um();
        const result<scale> tenths_of_um_per_s = by.speed_counts_of_um_per_s(tenth);
        const result<scale> um_per_s_of_tenth = by.um_per_s_of_speed_count(tenth);
        if (!um_of_count || !counts_of_um || !tenths_of_um_per_s || !um_per_s_of_tenth)
            return errc::out_of_range;
        axis made;
        made.um_of_count_ = *um_of_count;
        made.counts_of_um_ = *counts_of_um;
        made.tenths_of_um_per_s_ = *tenths_of_um_per_s;
        made.um_per_s_of_tenth_ = *um_per_s_of_tenth;
        made.counts_of_turn_ = by.counts_of_motor_turn();
        made.sign_ = by.direction() == count_direction::forward ? 1 : -1;
        return made;
    }
    /// The same of a feed that may have been refused.
    static constexpr result<axis> checked(const result<feed>& by) {
        return by ? checked(*by) : result<axis>{by.error()};
    }

    /// The place of a length from zero, to the nearest count.
    /// Errors: out_of_range (it has no count of 32 bits).
    constexpr result<std::int32_t> counts_of(micrometres length) const {
        return counts_of(length, [this](std::int32_t um) { return counts_of_um_.nearest(um); });
    }
    /// The counts of a way after others that have left `rest`, which becomes what this one leaves.
    /// Errors: out_of_range (`rest` is kept).
    constexpr result<std::int32_t> counts_of(micrometres way, std::int32_t& rest) const {
        return counts_of(way, [this, &rest](std::int32_t um) { return counts_of_um_.convert(um, rest); });
    }
    /// The length of a place, to the nearest um.
    /// Errors: out_of_range (beyond 2147 m).
    constexpr result<micrometres> length_of(std::int32_t counts) const {
        const result<std::int32_t> um = um_of_count_.nearest(counts);
        if (!um) return um.error();
        return micrometres{std::int64_t{*um} * sign_};
    }
    /// The um of counts within `most_counts()`, after others that have left `rest`, which becomes what these leave.
    constexpr std::int32_t um_of(std::int32_t counts, std::int32_t& rest) const {
        return um_of_count_.converted(counts, rest) * sign_;
    }
    /// So many counts, either way, have a length that converts.
    constexpr std::int32_t most_counts() const { return um_of_count_.most(); }

    /// The speed of the motor, to the nearest 0.1 r/min. Errors: out_of_range.
    constexpr result<motor_speed> motor_speed_of(micrometres_per_second speed) const {
        const result<std::int32_t> tenths = tenths_of_um_per_s_.nearest(speed.count());
        if (!tenths) return tenths.error();
        return motor_speed{*tenths * sign_};
    }
    /// The speed of the motor for a drive that counts `per_r_per_min` (1 .. 10) a r/min, to the nearest count.
    /// Errors: out_of_range (also beyond 214 m/s).
    constexpr result<std::int32_t> motor_counts_of(micrometres_per_second speed,
                                                   std::int32_t per_r_per_min) const {
        if (detail::is_beyond(speed.count(), 214'748'364)) return errc::out_of_range;
        std::int32_t rest = 0;
        const result<std::int32_t> tenths = tenths_of_um_per_s_.convert(speed.count() * per_r_per_min, rest);
        if (!tenths || detail::is_beyond(*tenths, 2'147'483'600)) return errc::out_of_range;
        // The half is looked for in what is not rounded yet: rounding twice would pass it.
        const std::int32_t from_half = *tenths - (rest < 0 ? 1 : 0) + 5;
        return (from_half < 0 ? -((9 - from_half) / 10) : from_half / 10) * sign_;
    }
    /// The speed of the axis, to the nearest um/s; limited to 32 bits.
    constexpr micrometres_per_second speed_of(motor_speed of) const {
        const result<std::int32_t> um = um_per_s_of_tenth_.nearest(of.count());
        const std::int32_t limit = of.count() < 0 ? -0x7FFF'FFFF : 0x7FFF'FFFF;
        return micrometres_per_second{um.value_or(limit) * sign_};
    }

    /// True if the drive counts up where the axis counts down.
    constexpr bool is_mirrored() const { return sign_ < 0; }
    /// The drive's counts in a turn of the motor.
    constexpr std::uint32_t counts_of_motor_turn() const { return counts_of_turn_; }

  private:
    scale um_of_count_ = scale::zero();
    scale counts_of_um_ = scale::refusing();
    scale tenths_of_um_per_s_ = scale::refusing();
    scale um_per_s_of_tenth_ = scale::zero();
    std::uint32_t counts_of_turn_ = 0;
    std::int8_t sign_ = 1;
};

} // namespace servobus
