// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The geometry of a machine with wheels: what a wheel rolls and counts in a turn, and two wheels on one axle. It is
// known to the compiler, which computes the ratios of it, exactly. A length, gear or count of 0 does not compile.
//
//     using namespace servobus::literals;
//     constexpr wheel tyre = rolling(652.3_mm, counts_per_turn{16384}); // measured; or diameter(207.6_mm)
//     constexpr axle base = axle::of({.left = tyre, .right = mirrored(tyre), .track = 500_mm});
//     static_assert(tyre.um_of_count().nearest(16384).value() == 652'300 && base.track() == 500_mm);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant wheel or axle that calls one does not compile, and the error names the rule.
inline void a_diameter_is_above_0_and_at_most_1_36_m() {}
inline void a_turn_travels_more_than_0_and_less_than_4_29_m() {}
inline void a_turn_has_1_to_2_28_counts() {}
inline void a_gear_has_1_to_65535_turns_on_each_side() {}
inline void a_track_is_above_0_and_less_than_16_m() {}
inline void a_count_turns_the_axle_by_less_than_0_4_rad() {}
inline void an_axle_in_lowest_terms_is_below_2_62_counts_times_nm() {}
} // namespace detail

/// The counts of the drive's position in a turn of its motor: of a ZLAC8015D 4 x the encoder's lines.
struct counts_per_turn {
    std::uint32_t count = 0; ///< 1 .. 2^28
};

/// A gear: so many turns of the motor are so many of the wheel, exactly. `gear{37, 10}` is 3.7 : 1.
struct gear {
    std::uint32_t motor_turns = 1;  ///< 1 .. 65535
    std::uint32_t output_turns = 1; ///< 1 .. 65535
};

/// A wheel, pulley or pinion with its drive: the travel of a turn, the counts of a turn of the motor, the gear, and the
/// direction in which the drive counts.
class wheel {
  public:
    /// The length of a count in um, exactly; one that is too fine does not compile.
    consteval scale um_of_count() const { return scale::of(travel(), 1000 * counts()); }
    /// The counts of a um, exactly; a ratio that is too fine does not compile.
    consteval scale counts_of_um() const { return scale::of(1000 * counts(), travel()); }
    /// The counts of speed, each worth `count` of the motor's r/min, of a um/s. It may be rounded by 2^-26 of itself.
    consteval scale speed_counts_of_um_per_s(unit count) const {
        return scale::close_to(std::uint64_t{60'000} * gear_.motor_turns * count.denominator,
                               travel() * count.numerator);
    }

    constexpr count_direction direction() const { return direction_; }
    constexpr gear gear_ratio() const { return gear_; }
    /// The travel of `counts()` counts, in nm.
    constexpr std::uint64_t travel() const { return std::uint64_t{travel_nm_} * gear_.output_turns; }
    /// The counts of `travel()`.
    constexpr std::uint64_t counts() const { return std::uint64_t{counts_.count} * gear_.motor_turns; }

    /// Makes a wheel of what a turn of it rolls (below 4.29 m), the counts of a turn of its motor, and the gear between.
    friend consteval wheel rolling(nanometres travel, counts_per_turn counts, gear ratio) {
        if (travel.count() <= 0 || travel.count() > 0xFFFF'FFFF)
            detail::a_turn_travels_more_than_0_and_less_than_4_29_m();
        if (counts.count == 0 || counts.count > 1u << 28) detail::a_turn_has_1_to_2_28_counts();
        if (ratio.motor_turns == 0 || ratio.motor_turns > 0xFFFF || ratio.output_turns == 0 ||
            ratio.output_turns > 0xFFFF)
            detail::a_gear_has_1_to_65535_turns_on_each_side();
        return wheel{static_cast<std::uint32_t>(travel.count()), counts, ratio, count_direction::forward};
    }
    /// The same wheel with a drive that counts the other way round, such as the second motor on an axle.
    friend consteval wheel mirrored(wheel other) {
        const bool is_forward = other.direction_ == count_direction::forward;
        other.direction_ = is_forward ? count_direction::mirrored : count_direction::forward;
        return other;
    }

  private:
    constexpr wheel(std::uint32_t travel_nm, counts_per_turn counts, gear ratio, count_direction direction)
        : travel_nm_{travel_nm}, counts_{counts}, gear_{ratio}, direction_{direction} {}

    std::uint32_t travel_nm_;
    counts_per_turn counts_;
    gear gear_;
    count_direction direction_;
};

consteval wheel rolling(nanometres travel, counts_per_turn counts, gear ratio = {});
consteval wheel mirrored(wheel other);

/// The circumference of a wheel of this diameter, rounded to 10 nm. A loaded tyre rolls less than it: measure the travel
/// of ten turns where millimetres a kilometre matter.
consteval nanometres diameter(nanometres across) {
    constexpr std::uint64_t pi = 0x3243'F6A8'885A'308D; // 2^-60
    if (across.count() <= 0 || across.count() > 1'360'000'000)
        detail::a_diameter_is_above_0_and_at_most_1_36_m();
    const std::uint64_t tens =
        detail::nearest_of(static_cast<std::uint64_t>(across.count()), pi / 10, std::uint64_t{1} << 60);
    return nanometres{static_cast<std::int64_t>(10 * tens)};
}

namespace detail {
/// The ratios of an axle.
struct axle_ratios {
    std::uint64_t left_turn = 0;      ///< what the axle turns in a count, in 2^-64 turn, modulo 2^64
    std::uint64_t right_turn = 0;     ///< likewise
    std::int64_t left_arc = 0;        ///< half the travel of a count, in 2^-40 um, negative if mirrored
    std::int64_t right_arc = 0;       ///< likewise
    std::uint32_t most_counts = 0;    ///< of a step: 2^20, or 8.3 m of one wheel
    std::int32_t most_difference = 0; ///< of the half travels of both wheels in a step, in 2^-8 um: 0.4 rad
    std::uint32_t half_track = 0;     ///< um of a wheel's travel for a urad of the axle, in parts of 2^29
};
} // namespace detail

/// Two wheels on one axle, each with lengths of its own, and the track between the points where they touch the ground.
class axle {
  public:
    struct parts {
        wheel left;
        wheel right;
        nanometres track;
    };

    /// Makes an axle and computes its ratios. A track of 0, of 16 m and more, and ratios that are too fine do not compile.
    static consteval axle of(const parts& p) {
        if (p.track.count() <= 0 || p.track.count() >= 16'000'000'000)
            detail::a_track_is_above_0_and_less_than_16_m();
        return axle{p};
    }

    constexpr const wheel& left() const { return parts_.left; }
    constexpr const wheel& right() const { return parts_.right; }
    constexpr nanometres track() const { return parts_.track; }
    /// Internal: for the odometry.
    constexpr const detail::axle_ratios& ratios() const { return ratios_; }

  private:
    consteval explicit axle(const parts& p) : parts_{p} {
        const auto track_nm = static_cast<std::uint64_t>(p.track.count());
        ratios_.left_turn = 0 - turn(p.left, track_nm);
        ratios_.right_turn = turn(p.right, track_nm);
        ratios_.left_arc = arc(p.left);
        ratios_.right_arc = arc(p.right);
        const std::uint32_t left = most_counts(p.left);
        const std::uint32_t right = most_counts(p.right);
        ratios_.most_counts = left < right ? left : right;
        ratios_.most_difference = static_cast<std::int32_t>(track_nm * 512 / 10'000);
        ratios_.half_track =
            static_cast<std::uint32_t>(detail::nearest_of(track_nm, 1u << 29, 2'000'000'000));
    }

    // travel / counts / track / 2 pi
    static consteval std::uint64_t turn(const wheel& w, std::uint64_t track_nm) {
        constexpr std::uint64_t over_2_pi = 0x28BE'60DB'9391'054A; // 2^64 / (2 pi)
        const std::uint64_t once = detail::greatest_divisor(w.travel(), w.counts());
        const std::uint64_t twice = detail::greatest_divisor(w.travel() / once, track_nm);
        const std::uint64_t counts = w.counts() / once;
        if (track_nm / twice > (std::uint64_t{1} << 62) / counts)
            detail::an_axle_in_lowest_terms_is_below_2_62_counts_times_nm();
        if (w.travel() / once / twice > counts * (track_nm / twice) * 2 / 5)
            detail::a_count_turns_the_axle_by_less_than_0_4_rad();
        const std::uint64_t a =
            detail::nearest_of(over_2_pi, w.travel() / once / twice, counts * (track_nm / twice));
        return w.direction() == count_direction::forward ? a : 0 - a;
    }
    static consteval std::int64_t arc(const wheel& w) {
        const auto a = static_cast<std::int64_t>(
            detail::nearest_of(w.travel(), std::uint64_t{1} << 39, 1000 * w.counts()));
        return w.direction() == count_direction::forward ? a : -a;
    }
    static consteval std::uint32_t most_counts(const wheel& w) {
        const std::uint64_t most = detail::floor_of(8'300'000'000, w.counts(), w.travel());
        return most < 1u << 20 ? static_cast<std::uint32_t>(most) : 1u << 20;
    }

    parts parts_;
    detail::axle_ratios ratios_;
};

} // namespace servobus
