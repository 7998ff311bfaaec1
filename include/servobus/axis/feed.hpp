// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a motor moves in a turn: the travel of a wheel or a screw, the gear, and the counts of the drive. It is known to the
// compiler, which computes the ratios of it, exactly. A length, gear or count of 0 does not compile.
//
//     using namespace servobus::literals;
//     constexpr feed wheel = rolling(652.3_mm, counts_per_turn{16384}); // measured; or diameter(207.6_mm)
//     constexpr feed screw = lead(5.08_mm, counts_per_turn{1000}, gear_ratio{37, 10});
//     static_assert(wheel.um_of_count().nearest(16384).value() == 652'300);
//     static_assert(screw.counts_of_um().nearest(5080).value() == 3700);
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

#include <servobus/axis/detail/exact.hpp>
#include <servobus/axis/lengths.hpp>
#include <servobus/axis/scale.hpp>
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

/// What a motor moves by a wheel, a pulley, a pinion or a screw: the travel of a turn of it, the counts of a turn of the motor,
/// the gear between, and the direction in which the drive counts. CiA 402 has the travel and the gear as feed constant (6092h)
/// and gear ratio (6091h).
class feed {
  public:
    /// The length of a count in um, exactly; one that is too fine does not compile.
    consteval scale um_of_count() const { return scale::of(travel(), 1000 * counts()); }
    /// The counts of a um, exactly; a ratio that is too fine does not compile.
    consteval scale counts_of_um() const { return scale::of(1000 * counts(), travel()); }
    /// The counts of speed, each worth `count` of the motor's r/min, of a um/s. It may be rounded, see `close_to`
    /// of a scale.
    consteval scale speed_counts_of_um_per_s(unit count) const {
        return scale::close_to(std::uint64_t{60'000} * gear_.motor_turns * count.denominator,
                               travel() * count.numerator);
    }

    /// The um/s of a count of speed, likewise.
    consteval scale um_per_s_of_speed_count(unit count) const {
        return scale::close_to(travel() * count.numerator,
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
        if (travel.count() <= 0 || travel.count() > 0xFFFF'FFFF)
            detail::a_turn_travels_more_than_0_and_less_than_4_29_m();
        if (counts.count == 0 || counts.count > std::uint32_t{1} << 28) detail::a_turn_has_1_to_2_28_counts();
        if (ratio.motor_turns == 0 || ratio.motor_turns > 0xFFFF || ratio.output_turns == 0 ||
            ratio.output_turns > 0xFFFF)
            detail::a_gear_has_1_to_65535_turns_on_each_side();
        return feed{static_cast<std::uint32_t>(travel.count()), counts, ratio, count_direction::forward};
    }
    /// The same with a drive that counts the other way round, such as the second motor on an axle.
    friend consteval feed mirrored(feed other) {
        const bool is_forward = other.direction_ == count_direction::forward;
        other.direction_ = is_forward ? count_direction::mirrored : count_direction::forward;
        return other;
    }

  private:
    consteval feed(std::uint32_t travel_nm, counts_per_turn counts, gear_ratio ratio,
                   count_direction direction)
        : travel_nm_{travel_nm}, counts_{counts}, gear_{ratio}, direction_{direction} {}

    std::uint32_t travel_nm_;
    counts_per_turn counts_;
    gear_ratio gear_;
    count_direction direction_;
};

consteval feed rolling(nanometres travel, counts_per_turn counts, gear_ratio ratio = {});
consteval feed mirrored(feed other);

/// A screw, which moves by its lead in a turn.
consteval feed lead(nanometres of, counts_per_turn counts, gear_ratio ratio = {}) {
    return rolling(of, counts, ratio);
}

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

} // namespace servobus
