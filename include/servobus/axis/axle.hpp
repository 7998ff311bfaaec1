// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Two wheels on one axle. The compiler computes the ratios of their lengths, exactly.
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

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant axle that calls one does not compile, and the error names the rule.
inline void a_track_is_above_0_and_less_than_16_m() {}
inline void a_count_turns_the_axle_by_less_than_0_4_rad() {}
inline void an_axle_in_lowest_terms_is_below_2_62_counts_times_nm() {}
} // namespace detail

namespace detail {
/// The ratios of an axle.
struct axle_ratios {
    std::uint64_t left_turn;      ///< what the axle turns in a count, in 2^-64 turn, modulo 2^64
    std::uint64_t right_turn;     ///< likewise
    std::int64_t left_arc;        ///< half the travel of a count, in 2^-40 um, negative if mirrored
    std::int64_t right_arc;       ///< likewise
    std::uint32_t most_counts;    ///< of a step: 2^20, or 8.3 m of one wheel
    std::int32_t most_difference; ///< of the half travels of both wheels in a step, in 2^-8 um: 0.4 rad
    std::uint32_t half_track;     ///< um of a wheel's travel for a urad of the axle, in parts of 2^29
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

    /// Makes an axle and computes its ratios. A track of 0, of 16 m and more, and ratios that are too fine do not compile.
    static consteval axle of(const parts& p) {
        if (p.track.count() <= 0 || p.track.count() >= 16'000'000'000)
            detail::a_track_is_above_0_and_less_than_16_m();
        return axle{p};
    }

    constexpr const feed& left() const { return parts_.left; }
    constexpr const feed& right() const { return parts_.right; }
    constexpr nanometres track() const { return parts_.track; }
    /// Internal: for the odometry.
    constexpr const detail::axle_ratios& ratios() const { return ratios_; }

  private:
    consteval explicit axle(const parts& p)
        : parts_{p}, ratios_{ratios_of(p, static_cast<std::uint64_t>(p.track.count()))} {}

    static consteval detail::axle_ratios ratios_of(const parts& p, std::uint64_t track_nm) {
        const std::uint32_t left = most_counts(p.left);
        const std::uint32_t right = most_counts(p.right);
        return {.left_turn = 0 - turn(p.left, track_nm),
                .right_turn = turn(p.right, track_nm),
                .left_arc = arc(p.left),
                .right_arc = arc(p.right),
                .most_counts = left < right ? left : right,
                .most_difference = static_cast<std::int32_t>(track_nm * 512 / 10'000),
                .half_track = static_cast<std::uint32_t>(
                    detail::nearest_of(track_nm, std::uint32_t{1} << 29, 2'000'000'000))};
    }

    // travel / counts / track / 2 pi
    static consteval std::uint64_t turn(const feed& w, std::uint64_t track_nm) {
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
    static consteval std::int64_t arc(const feed& w) {
        const auto a = static_cast<std::int64_t>(
            detail::nearest_of(w.travel(), std::uint64_t{1} << 39, 1000 * w.counts()));
        return w.direction() == count_direction::forward ? a : -a;
    }
    static consteval std::uint32_t most_counts(const feed& w) {
        const std::uint64_t most = detail::floor_of(8'300'000'000, w.counts(), w.travel());
        return most < std::uint32_t{1} << 20 ? static_cast<std::uint32_t>(most) : std::uint32_t{1} << 20;
    }

    parts parts_;
    detail::axle_ratios ratios_;
};

} // namespace servobus
