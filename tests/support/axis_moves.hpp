// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many random moves and feedbacks of one axis, and their sums in 64 bits, which are exact.
#pragma once

#include <cstdint>
#include <random>

#include <servobus/axis/axis_place.hpp>

namespace axis_moves {

inline constexpr std::int64_t um_a_turn = 652'300, counts_a_turn = 16'384;
inline constexpr servobus::feed wheel = servobus::rolling(
    servobus::micrometres{um_a_turn}, servobus::counts_per_turn{static_cast<std::uint32_t>(counts_a_turn)});
inline constexpr auto forward = servobus::axis::of(wheel);
inline constexpr auto mirrored = servobus::axis::of(servobus::mirrored(wheel));

/// The whole number that is nearest to `a / b`, halves up.
inline std::int64_t nearest(std::int64_t a, std::int64_t b) {
    const std::int64_t twice = 2 * a + b;
    return twice >= 0 ? twice / (2 * b) : -((2 * b - 1 - twice) / (2 * b));
}

/// The counts by which the sum of random relative moves differs from the nearest count. One in eight does not begin.
inline std::int64_t drift(const servobus::axis& of, int moves) {
    using namespace servobus;
    std::mt19937 random{44};
    axis_place place{of};
    std::int64_t um = 0;
    std::int64_t counts = 0;
    for (int i = 0; i < moves; ++i) {
        const auto way = static_cast<std::int32_t>(random() % 20'001) - 10'000;
        std::int32_t rest = 0;
        const result<std::int32_t> m = place.plan(micrometres{way}, rest);
        if (random() % 8 == 0) continue;
        place.keep(rest);
        um += way;
        counts += of.is_mirrored() ? -*m : *m;
    }
    return counts - nearest(um * counts_a_turn, um_a_turn);
}

struct followed {
    bool are_equal = true;
    std::int64_t wraps = 0;
};

/// Follows feedbacks of 9000 counts on average, and compares the micrometres after each.
inline followed follow(const servobus::axis& of, int feedbacks) {
    using namespace servobus;
    std::mt19937 random{43};
    axis_place place{of};
    std::uint32_t raw = 0x7FFF'0000;
    place.follow(raw, 1);
    followed f;
    const std::int64_t sign = of.is_mirrored() ? -1 : 1;
    std::int64_t counts = 0x7FFF'0000;
    for (int i = 0; i < feedbacks; ++i) {
        const auto step = static_cast<std::int32_t>(random() % 100'001) - 41'000;
        raw += static_cast<std::uint32_t>(step);
        counts += step;
        place.follow(raw, 1);
        // At most half a um off.
        const std::int64_t off = sign * place.length().count() * counts_a_turn - counts * um_a_turn;
        f.are_equal &= 2 * off <= counts_a_turn && -2 * off <= counts_a_turn;
    }
    f.wraps = (counts >> 32);
    return f;
}

} // namespace axis_moves
