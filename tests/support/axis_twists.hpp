// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Twists at random, and the speeds of two wheels at them in long double: scaled by one factor where a wheel would
// exceed its limit.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <servobus/axis/differential.hpp>

namespace axis_twists {

using number = long double;

/// A machine, and the same in long double.
struct subject {
    const char* name;
    servobus::differential machine;
    std::uint32_t per_r_per_min; ///< counts
    number left_counts;          ///< of a um/s
    number right_counts;         ///< likewise
    number half_track;           ///< um
    std::int32_t limit;
};

consteval subject subject_of(const char* name, const servobus::axle::parts& of, std::uint32_t per_r_per_min,
                             std::int32_t limit) {
    const auto counts = [per_r_per_min](const servobus::feed& w) {
        const number um_a_turn =
            static_cast<number>(w.travel()) / 1000 / static_cast<number>(w.ratio().motor_turns);
        const number c = 60 / um_a_turn * per_r_per_min;
        return w.direction() == servobus::count_direction::forward ? c : -c;
    };
    return {name,
            servobus::differential::of(of),
            per_r_per_min,
            counts(of.left),
            counts(of.right),
            static_cast<number>(of.track.count()) / 2000,
            limit};
}

/// How far the speeds of many twists are off, in counts beyond 4 um/s.
struct judged {
    number worst = 0;
    long limited = 0;
    long above = 0;           ///< wheels above their limit
    long wrongly_limited = 0; ///< `is_limited` does not say what is
};

inline number beyond(number off, number counts) {
    const number more = std::fabs(off) - 4 * std::fabs(counts);
    return more < 0 ? 0 : more;
}

inline void judge(const subject& s, std::int32_t speed, std::int32_t turn, judged& all) {
    using namespace servobus;
    const wheel_speeds w =
        s.machine.wheels({speed * units::micrometre_per_second, turn * units::microradian_per_second},
                         s.per_r_per_min, static_cast<std::uint32_t>(s.limit));
    const number side = static_cast<number>(turn) * s.half_track / 1'000'000;
    number left = (static_cast<number>(speed) - side) * s.left_counts;
    number right = (static_cast<number>(speed) + side) * s.right_counts;
    const number most = std::fmax(std::fabs(left), std::fabs(right));
    if (most > static_cast<number>(s.limit)) {
        left *= static_cast<number>(s.limit) / most;
        right *= static_cast<number>(s.limit) / most;
    }
    all.above += w.left > s.limit || w.left < -s.limit || w.right > s.limit || w.right < -s.limit;
    all.limited += w.is_limited;
    const number faster = std::fmax(std::fabs(s.left_counts), std::fabs(s.right_counts));
    const bool must_be = most > static_cast<number>(s.limit) + 0.5L + 4 * faster;
    const bool may_be = most > static_cast<number>(s.limit) + 0.5L - 4 * faster;
    all.wrongly_limited += (must_be && !w.is_limited) || (!may_be && w.is_limited);
    all.worst = std::fmax(all.worst, beyond(static_cast<number>(w.left) - left, s.left_counts));
    all.worst = std::fmax(all.worst, beyond(static_cast<number>(w.right) - right, s.right_counts));
}

/// Numbers of all sizes, the ends of the range and 0 among them.
inline std::int32_t any_number(std::mt19937& random) {
    constexpr std::int32_t ends[]{0, 1, -1, 0x7FFF'FFFF, -0x7FFF'FFFF, -0x7FFF'FFFF - 1};
    if (random() % 16 == 0) return ends[random() % 6];
    const auto size = static_cast<std::int32_t>(random() & 0x7FFF'FFFFu) >> random() % 31;
    return random() % 2 == 0 ? size : -size;
}

inline judged judge_any(const subject& s, std::uint32_t seed, int twists) {
    std::mt19937 random{seed};
    judged all;
    for (int i = 0; i < twists; ++i) {
        const std::int32_t speed = any_number(random);
        judge(s, speed, any_number(random), all);
    }
    return all;
}

inline constexpr servobus::feed tyre =
    servobus::rolling(servobus::micrometres{652'300}, servobus::counts_per_turn{16384});
inline constexpr servobus::feed geared =
    servobus::rolling(servobus::diameter(servobus::micrometres{150'100}), servobus::counts_per_turn{4096},
                      servobus::gear_ratio{37, 10});
inline constexpr servobus::feed roller =
    servobus::rolling(servobus::micrometres{10'000}, servobus::counts_per_turn{1000});

inline constexpr servobus::axle::parts usual{
    .left = tyre, .right = mirrored(tyre), .track = servobus::micrometres{500'000}};
inline constexpr servobus::axle::parts uneven{
    .left = geared, .right = mirrored(tyre), .track = servobus::micrometres{1'234'567}};
inline constexpr servobus::axle::parts wide{
    .left = mirrored(tyre), .right = tyre, .track = servobus::micrometres{15'900'000}};
inline constexpr servobus::axle::parts tiny{
    .left = roller, .right = roller, .track = servobus::micrometres{50'000}};

inline constexpr subject subjects[]{
    subject_of("whole r/min", usual, 1, 300),
    subject_of("tenths of r/min", usual, 10, 3000),
    subject_of("a limit of 1", usual, 1, 1),
    subject_of("two wheels of different size and gear", uneven, 1, 3000),
    subject_of("a wide track", wide, 10, 10'000),
    subject_of("the highest limit", usual, 10, 32'767),
    subject_of("small wheels", tiny, 7, 32'767),
};

} // namespace axis_twists
