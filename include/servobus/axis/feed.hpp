// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A feed: the travel of a wheel or a screw in a turn, the gear, and the counts of the drive, of which axes and axles
// are made. As a constant, one with a length, gear or count of 0 does not compile. `feed::checked` makes one of numbers
// that are known at run time only, and refuses it.
//
//     using namespace servobus::literals;
//     constexpr feed wheel = rolling(652.3_mm, counts_per_turn{16384}); // measured; or diameter(207.6_mm)
//     constexpr feed screw = lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10});
//     static_assert(wheel.um_of_count()->nearest(16384).value() == 652'300);
//     static_assert(screw.counts_of_um()->nearest(5080).value() == 3700);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
#include <servobus/core/result.hpp>
#include <servobus/core/status.hpp>
#include <servobus/registers/unit.hpp>

namespace servobus {

namespace detail {
// Not constexpr on purpose: a constant feed that calls one does not compile, and the error names the rule.
inline void a_diameter_is_above_0_and_at_most_1_36_m() {}
inline void a_turn_travels_more_than_0_and_less_than_4_29_m() {}
inline void a_turn_has_1_to_2_28_counts() {}
inline void a_gear_has_1_to_65535_turns_on_each_side() {}
} // namespace detail

/// The counts of the drive's position in a turn of its motor: of a ZLAC8015D 4 x the encoder's lines.
struct counts_per_turn {
    std::uint32_t count = 0; ///< 1 .. 2^28
};

/// A gear: so many turns of the motor are so many of the wheel, exactly. `gear_ratio{37, 10}` is 3.7 : 1.
struct gear_ratio {
    std::uint32_t motor_turns = 1;  ///< 1 .. 65535
    std::uint32_t output_turns = 1; ///< 1 .. 65535
};

/// What a motor moves by a wheel, a pulley, a pinion or a screw: the travel of a turn of it, the counts of a turn of
/// the motor, the gear between, and the direction in which the drive counts. CiA 402 has the travel and the gear as
/// feed constant (6092h) and gear ratio (6091h).
class feed {
  public:
    /// Nothing: it has no counts, and no axis or axle is made of it.
    constexpr feed() = default;

    /// Makes it of numbers that are known at run time only, as `rolling` does of constants.
    /// Errors: out_of_range (a travel that is not above 0 and below 4.29 m, a turn without counts or with more than
    /// 2^28, a gear without turns or with more than 65535 on a side).
    static constexpr result<feed> checked(nanometres travel, counts_per_turn counts, gear_ratio ratio = {}) {
        if (!is_travel(travel) || !is_count(counts) || !is_gear(ratio)) return errc::out_of_range;
        return feed{static_cast<std::uint32_t>(travel.count()), counts, ratio};
    }

    /// The length of a count in um, exactly. Errors: out_of_range (too fine for a scale).
    constexpr result<scale> um_of_count() const { return scale::checked(travel(), 1000 * counts()); }
    /// The counts of a um, exactly. Errors: likewise.
    constexpr result<scale> counts_of_um() const { return scale::checked(1000 * counts(), travel()); }
    /// The counts of speed, each worth `count` of the motor's r/min, of a um/s. It may be rounded, see `close_to`
    /// of a scale. Errors: out_of_range.
    constexpr result<scale> speed_counts_of_um_per_s(unit count) const {
        return scale::checked_close_to(std::uint64_t{60'000} * gear_.motor_turns * count.denominator,
                                       travel() * count.numerator);
    }
    /// The um/s of a count of speed, likewise.
    constexpr result<scale> um_per_s_of_speed_count(unit count) const {
        return scale::checked_close_to(travel() * count.numerator,
                                       std::uint64_t{60'000} * gear_.motor_turns * count.denominator);
    }

    constexpr count_direction direction() const { return direction_; }
    constexpr std::uint32_t counts_of_motor_turn() const { return counts_.count; }
    constexpr gear_ratio ratio() const { return gear_; }
    /// The travel of `counts()` counts, in nm.
    constexpr std::uint64_t travel() const { return std::uint64_t{travel_nm_} * gear_.output_turns; }
    /// The counts of `travel()`.
    constexpr std::uint64_t counts() const { return std::uint64_t{counts_.count} * gear_.motor_turns; }

    /// Makes it of the travel of a turn (below 4.29 m), the counts of a turn of the motor, and the gear between.
    friend consteval feed rolling(nanometres travel, counts_per_turn counts, gear_ratio ratio) {
        if (!is_travel(travel)) detail::a_turn_travels_more_than_0_and_less_than_4_29_m();
        if (!is_count(counts)) detail::a_turn_has_1_to_2_28_counts();
        if (!is_gear(ratio)) detail::a_gear_has_1_to_65535_turns_on_each_side();
        return *checked(travel, counts, ratio);
    }
    /// The same with a drive that counts the other way round, such as the second motor on an axle.
    friend constexpr feed mirrored(feed other) {
        const bool is_forward = other.direction_ == count_direction::forward;
        other.direction_ = is_forward ? count_direction::mirrored : count_direction::forward;
        return other;
    }

  private:
    constexpr feed(std::uint32_t travel_nm, counts_per_turn counts, gear_ratio ratio)
        : travel_nm_{travel_nm}, counts_{counts}, gear_{ratio} {}

    static constexpr bool is_travel(nanometres of) { return of.count() > 0 && of.count() <= 0xFFFF'FFFF; }
    static constexpr bool is_count(counts_per_turn of) {
        return of.count > 0 && of.count <= std::uint32_t{1} << 28;
    }
    static constexpr bool is_gear(gear_ratio of) {
        return of.motor_turns > 0 && of.motor_turns <= 0xFFFF && of.output_turns > 0 &&
               of.output_turns <= 0xFFFF;
    }

    std::uint32_t travel_nm_ = 0;
    counts_per_turn counts_{};
    gear_ratio gear_{};
    count_direction direction_ = count_direction::forward;
};

consteval feed rolling(nanometres travel, counts_per_turn counts, gear_ratio ratio = {});
constexpr feed mirrored(feed other);

/// A screw, which moves by its lead in a turn.
consteval feed lead(nanometres of, counts_per_turn counts, gear_ratio ratio = {}) {
    return rolling(of, counts, ratio);
}

/// The circumference of a wheel of a diameter that is known at run time only, as `diameter`.
/// Errors: out_of_range (it is not above 0 and at most 1.36 m).
constexpr result<nanometres> checked_diameter(nanometres across) {
    constexpr std::uint64_t pi = 0x3243'F6A8'885A'308D; // 2^-60
    if (across.count() <= 0 || across.count() > 1'360'000'000) return errc::out_of_range;
    const std::uint64_t tens =
        detail::nearest_of(static_cast<std::uint64_t>(across.count()), pi / 10, std::uint64_t{1} << 60);
    return nanometres{static_cast<std::int64_t>(10 * tens)};
}
/// The circumference of a wheel of this diameter, rounded to 10 nm. A loaded tyre rolls less than it: measure the
/// travel of ten turns where millimetres a kilometre matter.
consteval nanometres diameter(nanometres across) {
    const result<nanometres> around = checked_diameter(across);
    if (!around) detail::a_diameter_is_above_0_and_at_most_1_36_m();
    return *around;
}

} // namespace servobus
