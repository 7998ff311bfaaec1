// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels on one axle, and the ratios of their lengths, exactly. The compiler computes those of a constant.
//
//     using namespace servobus::literals;
//     constexpr feed wheel = rolling(652.3_mm, counts_per_turn{16384});
//     constexpr axle base = axle::of({.left = wheel, .right = mirrored(wheel), .track = 500_mm});
//     static_assert(base.track() == 500_mm);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/feed.hpp>
#include <servobus/axis/lengths.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant axle that calls one does not compile, and the error names the rule.
inline void a_track_is_at_least_1_mm_and_less_than_16_m() {}
inline void a_count_turns_the_axle_by_less_than_0_4_rad() {}
inline void an_axle_in_lowest_terms_is_below_2_62_counts_times_nm() {}
} // namespace detail

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
        feed left;
        feed right;
        nanometres track;
    };

    /// Without wheels: no step of it is added, and no drive is taken over with it, since it has no counts.
    constexpr axle() = default;

    /// Makes an axle and computes its ratios. A track of less than 1 mm, of 16 m and more, and ratios that are too fine
    /// do not compile.
    static consteval axle of(const parts& p) {
        if (!has_wheels(p)) detail::a_turn_has_1_to_2_28_counts();
        if (!has_track(p)) detail::a_track_is_at_least_1_mm_and_less_than_16_m();
        const turning left = turning_of(p.left, p.track);
        const turning right = turning_of(p.right, p.track);
        if (!left.is_coarse() || !right.is_coarse())
            detail::an_axle_in_lowest_terms_is_below_2_62_counts_times_nm();
        if (left.is_too_far() || right.is_too_far()) detail::a_count_turns_the_axle_by_less_than_0_4_rad();
        return *checked(p);
    }
    /// The same of parts that are known at run time only. It divides.
    /// Errors: out_of_range (a wheel of nothing, a track of less than 1 mm, or of 16 m and more, ratios that are too
    /// fine or turn the axle by more than 0.4 rad in a count).
    static constexpr result<axle> checked(const parts& p) {
        if (!has_wheels(p) || !has_track(p)) return errc::out_of_range;
        const turning left = turning_of(p.left, p.track);
        const turning right = turning_of(p.right, p.track);
        if (!left.is_coarse() || !right.is_coarse() || left.is_too_far() || right.is_too_far())
            return errc::out_of_range;
        axle made;
        made.parts_ = p;
        made.ratios_ = ratios_of(p, static_cast<std::uint64_t>(p.track.count()), left, right);
        return made;
    }

    constexpr const feed& left() const { return parts_.left; }
    constexpr const feed& right() const { return parts_.right; }
    constexpr nanometres track() const { return parts_.track; }
    /// Internal: for the odometry.
    constexpr const detail::axle_ratios& ratios() const { return ratios_; }

  private:
    // Says what an axle turns in a count: travel / (counts * track), in lowest terms.
    struct turning {
        std::uint64_t travel = 0;
        std::uint64_t parts = 0; // 0 if it has more than 62 bits

        constexpr bool is_coarse() const { return parts != 0; }
        constexpr bool is_too_far() const { return travel > parts * 2 / 5; }
    };

    static constexpr bool has_wheels(const parts& p) { return p.left.counts() > 0 && p.right.counts() > 0; }
    static constexpr bool has_track(const parts& p) {
        return p.track.count() >= 1'000'000 && p.track.count() < 16'000'000'000;
    }
    static constexpr turning turning_of(const feed& w, nanometres track) {
        const auto across = static_cast<std::uint64_t>(track.count());
        const std::uint64_t once = detail::greatest_divisor(w.travel(), w.counts());
        const std::uint64_t twice = detail::greatest_divisor(w.travel() / once, across);
        const std::uint64_t counts = w.counts() / once;
        if (across / twice > (std::uint64_t{1} << 62) / counts) return {};
        return {w.travel() / once / twice, counts * (across / twice)};
    }
    static constexpr detail::axle_ratios ratios_of(const parts& p, std::uint64_t track_nm,
                                                   const turning& by_left, const turning& by_right) {
        const std::uint32_t left = most_counts(p.left);
        const std::uint32_t right = most_counts(p.right);
        return {.left_turn = 0 - turn(p.left, by_left),
                .right_turn = turn(p.right, by_right),
                .left_arc = arc(p.left),
                .right_arc = arc(p.right),
                .most_counts = left < right ? left : right,
                .most_difference = static_cast<std::int32_t>(track_nm * 512 / 10'000),
                .half_track = static_cast<std::uint32_t>(
                    detail::nearest_of(track_nm, std::uint32_t{1} << 29, 2'000'000'000))};
    }
    static constexpr std::uint64_t turn(const feed& w, const turning& by) {
        constexpr std::uint64_t over_2_pi = 0x28BE'60DB'9391'054A; // 2^64 / (2 pi)
        const std::uint64_t a = detail::nearest_of(over_2_pi, by.travel, by.parts);
        return w.direction() == count_direction::forward ? a : 0 - a;
    }
    static constexpr std::int64_t arc(const feed& w) {
        const auto a = static_cast<std::int64_t>(
            detail::nearest_of(w.travel(), std::uint64_t{1} << 39, 1000 * w.counts()));
        return w.direction() == count_direction::forward ? a : -a;
    }
    static constexpr std::uint32_t most_counts(const feed& w) {
        const std::uint64_t most = detail::floor_of(8'300'000'000, w.counts(), w.travel());
        return most < std::uint32_t{1} << 20 ? static_cast<std::uint32_t>(most) : std::uint32_t{1} << 20;
    }

    parts parts_{};
    detail::axle_ratios ratios_{};
};

} // namespace servobus
